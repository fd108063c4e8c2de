// SPDX-License-Identifier: BSD-2-Clause
// Metrics of the gateway, its interfaces, its networks and their reservations.
#include <limits>
#include <set>
#include <span>

#include "core/gates/frame_reason.hpp"
#include "tools/exporter/exposition.hpp"
#include "tools/exporter/metrics.hpp"

namespace mlcca::exporter {
namespace {

constexpr double kNanosecond = 1e-9;
constexpr double kPartsOfLoss = 1e9;
constexpr double kPartsOfTime = 1e6;
constexpr double kBitsInAByte = 8;
constexpr std::uint64_t kForEver = std::numeric_limits<std::uint64_t>::max();

double seconds(std::uint64_t ns) {
  return ns == kForEver ? std::numeric_limits<double>::infinity()
                        : static_cast<double>(ns) * kNanosecond;
}

/// The first `most` elements; the number of the others is added to `left_out`.
template <class T>
std::span<const T> first(const std::vector<T>& all, std::size_t most, std::size_t& left_out) {
  if (all.size() <= most) return all;
  left_out += all.size() - most;
  return std::span(all).first(most);
}

void add_one(std::string_view name, std::string_view type, std::string_view help, auto value,
             std::string& page) {
  Family family(name, type, help);
  family.add(value);
  family.append_to(page);
}

/// The exit status of `mlccactl status --check`.
std::uint64_t number_of(control::HealthState state) {
  switch (state) {
    case control::HealthState::healthy:
      return 0;
    case control::HealthState::degraded:
      return 1;
    case control::HealthState::closed:
      return 2;
    case control::HealthState::unknown:
      break;
  }
  return 3;
}

void add_health(const control::Health& health, const Most& most, LeftOut& left_out,
                std::string& page) {
  add_health_state(health.state, page);
  add_one("mlcca_health_reasons", "gauge", "Reasons why the health is not 'healthy'.",
          static_cast<std::uint64_t>(health.reasons.size()) + health.left_out, page);
  Family reasons("mlcca_health_reason", "gauge",
                 "A reason that holds now; N stands for each number and address in it. Always 1.");
  std::set<std::string> different;
  for (const auto& reason : health.reasons) different.insert(kind_of(reason));
  std::size_t listed = 0;
  for (const auto& reason : different)
    if (listed++ < most.others) reasons.add(Labels{{"reason", reason}}, true);
  reasons.append_to(page);
  left_out["reasons"] = health.left_out + (listed > most.others ? listed - most.others : 0);
}

Labels of_interface(const control::Interface& i) {
  return {{"interface", i.name}, {"network", i.network}};
}

struct Frames {
  Family passed{"mlcca_interface_frames_passed_total", "counter",
                "Frames that passed the gate, by kind: admitted, or what the gate leaves alone."};
  Family dropped{"mlcca_interface_frames_dropped_total", "counter",
                 "Frames that the gate dropped, by reason."};
  Family would_drop{"mlcca_interface_frames_would_drop_total", "counter",
                    "Frames that audit mode passed, by the reason for which they would be "
                    "dropped."};

  void add(const Labels& interface, const char* direction, const control::Traffic& traffic) {
    const auto labels = interface.with("direction", direction);
    add_passed(labels, traffic);
    add_by_reason(labels, traffic.dropped, traffic.reasons, dropped);
    add_by_reason(labels, traffic.would_drop, traffic.would_drop_reasons, would_drop);
  }

 private:
  void add_passed(const Labels& labels, const control::Traffic& traffic) {
    passed.add(labels.with("kind", "admitted"), traffic.passed);
    for (const auto& count : traffic.reasons)
      if (count.passed && core::frame_reason(count.reason) != core::FrameReason::passed)
        passed.add(labels.with("kind", count.reason), count.frames);
  }

  /// Adds counts by reason. Frames without a stated reason have the reason "other", so that the sum
  /// is the total.
  static void add_by_reason(const Labels& labels, std::uint64_t all,
                            const std::vector<control::ReasonCount>& reasons, Family& to) {
    std::uint64_t stated = 0;
    for (const auto& count : reasons) {
      if (count.passed) continue;
      to.add(labels.with("reason", count.reason), count.frames);
      stated += count.frames;
    }
    to.add(labels.with("reason", "other"), all > stated ? all - stated : std::uint64_t{0});
  }
};

void add_interfaces(std::span<const control::Interface> interfaces, std::string& page) {
  Family present("mlcca_interface_present", "gauge", "Whether the interface is there.");
  Family up("mlcca_interface_up", "gauge", "Whether its link is up.");
  Family attached("mlcca_interface_gate_attached", "gauge",
                  "Whether the gate is attached; not of an interface without a gate by design.");
  Family problem("mlcca_interface_problem", "gauge",
                 "Whether something is wrong with it, or runs before its gate.");
  Family can_state("mlcca_interface_can_state", "gauge",
                   "The state of the CAN controller; 1 for the one that it is in.");
  Family bitrate("mlcca_interface_bitrate_bytes_per_second", "gauge",
                 "The bit rate of the CAN bus in bytes/s; not there where it is unknown.");
  Family slots("mlcca_interface_slots", "gauge", "Slots of its gate that are in use.");
  Family repaired("mlcca_interface_gate_repaired_total", "counter",
                  "How often the gate was put back, or first.");
  Family bypassed("mlcca_interface_frames_bypassed_total", "counter",
                  "Frames that were sent past the gate.");
  Frames frames;
  for (const auto& i : interfaces) {
    const auto labels = of_interface(i);
    present.add(labels, i.ifindex != 0);
    up.add(labels, i.up);
    if (i.profile != "none" || i.attached) attached.add(labels, i.attached);
    problem.add(labels, !i.problem.empty() || !i.drift.empty());
    if (!i.can_state.empty()) can_state.add(labels.with("state", i.can_state), true);
    if (i.bitrate != 0) bitrate.add(labels, i.bitrate / kBitsInAByte);
    slots.add(labels, std::uint64_t{i.slots});
    repaired.add(labels, i.repaired);
    bypassed.add(labels, i.bypassed);
    frames.add(labels, "in", i.ingress);
    frames.add(labels, "out", i.egress);
  }
  for (const auto* family :
       {&present, &up, &attached, &problem, &can_state, &bitrate, &slots, &repaired, &bypassed,
        &frames.passed, &frames.dropped, &frames.would_drop})
    family->append_to(page);
}

void add_links(std::span<const control::MeshLink> links, std::string& page) {
  Family rate("mlcca_link_believed_rate_bytes_per_second", "gauge",
              "What a link of a mesh is believed to carry; 0: nothing.");
  Family loss("mlcca_link_loss_ratio", "gauge", "Loss of the link as it is reported.");
  Family busy("mlcca_link_busy_ratio", "gauge", "Share of the time in which its medium is busy.");
  Family age("mlcca_link_report_age_seconds", "gauge", "Age of what is known of the link.");
  for (const auto& l : links) {
    const Labels labels{
        {"network", l.network}, {"from", l.from}, {"to", l.to}, {"source", l.source}};
    rate.add(labels, static_cast<double>(l.believed_rate) / kBitsInAByte);
    if (l.loss_known) loss.add(labels, static_cast<double>(l.loss) / kPartsOfLoss);
    if (l.busy_known) busy.add(labels, l.busy / kPartsOfTime);
    age.add(labels, seconds(l.age_ns));
  }
  for (const auto* family : {&rate, &loss, &busy, &age}) family->append_to(page);
}

void add_resources(std::span<const control::Resource> resources, std::string& page) {
  Family reserved("mlcca_resource_reserved_ratio", "gauge",
                  "Share of a network, gateway, bus or contention domain that is reserved.");
  Family background("mlcca_resource_background_ratio", "gauge", "Share of it that others take.");
  for (const auto& r : resources) {
    if (!r.capacity_known || r.capacity == 0) continue;
    const Labels labels{{"resource", r.name}, {"kind", r.kind}};
    const auto whole = static_cast<double>(r.capacity);
    reserved.add(labels, static_cast<double>(r.reserved) / whole);
    background.add(labels, static_cast<double>(r.background) / whole);
  }
  reserved.append_to(page);
  background.append_to(page);
}

}  // namespace

void add_health_state(control::HealthState state, std::string& page) {
  add_one("mlcca_health", "gauge",
          "As the exit status of 'mlccactl status --check': 0 healthy, 1 degraded, 2 closed, "
          "3 unknown, because mlccad does not answer.",
          number_of(state), page);
}

void add_status(const control::Status& s, const Most& most, LeftOut& left_out, std::string& page) {
  Family info("mlcca_info", "gauge", "Which gateway of which system this is; always 1.");
  info.add(Labels{{"version", s.version}, {"gateway", s.gateway}, {"system", s.system}}, true);
  info.append_to(page);
  add_health(s.health, most, left_out, page);
  Family mode("mlcca_mode", "gauge", "1 for the mode that the gates are in.");
  for (const char* one : {"audit", "enforce"}) mode.add(Labels{{"mode", one}}, s.mode == one);
  mode.append_to(page);
  add_one("mlcca_gates_open", "gauge",
          "Whether the verdicts are in force; 0: everything is denied.", s.open, page);
  add_one("mlcca_grace_seconds", "gauge",
          "How long the verdicts stay in force when mlccad dies or hangs.", seconds(s.grace_ns),
          page);
  add_one("mlcca_lapses_total", "counter",
          "How often the kernel closed the gates because no heart-beat came.", s.lapses, page);
  add_one("mlcca_start_time_seconds", "gauge", "When mlccad started, in seconds since 1970.",
          s.started_unix_s, page);
  add_one("mlcca_description_load_time_seconds", "gauge",
          "When the description in force was read, in seconds since 1970.", s.loaded_unix_s, page);
  add_one("mlcca_reload_refused", "gauge",
          "Whether the latest reload was refused: the former description is in force.",
          !s.reload_error.empty(), page);
  Family deliveries("mlcca_deliveries", "gauge", "Deliveries of channels, by verdict.");
  deliveries.add(Labels{{"verdict", "granted"}}, std::uint64_t{s.channels_granted});
  deliveries.add(Labels{{"verdict", "refused"}}, std::uint64_t{s.channels_refused});
  deliveries.append_to(page);
  add_interfaces(first(s.interfaces, most.others, left_out["interfaces"]), page);
}

void add_networks(const Reports& reports, const Most& most, LeftOut& left_out, std::string& page) {
  if (reports.networks) {
    Family available("mlcca_network_available", "gauge", "Whether the network can be used.");
    Family capacity("mlcca_network_capacity_bytes_per_second", "gauge",
                    "What can be reserved of the network; not there where none is stated.");
    Family reserved("mlcca_network_reserved_bytes_per_second", "gauge", "What is reserved of it.");
    for (const auto& n : first(reports.networks->networks, most.others, left_out["networks"])) {
      const Labels labels{{"network", n.name}, {"kind", n.kind}};
      available.add(labels, n.available);
      if (!n.capacity_known) continue;
      capacity.add(labels, n.capacity);
      reserved.add(labels, n.reserved);
    }
    for (const auto* family : {&available, &capacity, &reserved}) family->append_to(page);
  }
  if (reports.reservations)
    add_resources(first(reports.reservations->resources, most.others, left_out["resources"]), page);
  if (reports.routes) add_links(first(reports.routes->links, most.others, left_out["links"]), page);
}

void add_gates(const control::Gates& gates, const Most& most, LeftOut& left_out,
               std::string& page) {
  Family room("mlcca_gate_slots_limit", "gauge", "Slots that the gate has.");
  Family masked("mlcca_gate_masked_slots", "gauge",
                "Slots with a mask, of the direction that has more of them.");
  Family masked_room("mlcca_gate_masked_slots_limit", "gauge",
                     "Slots with a mask that a direction of the gate has.");
  Family passed("mlcca_gate_control_frames_passed_total", "counter",
                "Frames of control traffic that passed, by its kind.");
  Family dropped("mlcca_gate_control_frames_dropped_total", "counter",
                 "Frames of control traffic that were dropped, by its kind.");
  // Several slots of a gate may be of the same kind.
  struct Count {
    std::uint64_t passed = 0;
    std::uint64_t dropped = 0;
  };
  std::map<std::string, Count> by_kind;
  std::size_t unlisted = 0;
  for (const auto& g : first(gates.gates, most.others, unlisted)) {
    const Labels labels{{"interface", g.interface}, {"network", g.network}};
    room.add(labels, std::uint64_t{g.slots_limit});
    if (g.masked_slots_limit != 0) {
      masked.add(labels, std::uint64_t{g.masked_slots});
      masked_room.add(labels, std::uint64_t{g.masked_slots_limit});
    }
    for (const auto& slot : g.control) {
      auto named = labels.with("direction", slot.egress ? "out" : "in");
      named.add("kind", slot.name);
      if (by_kind.size() >= most.others && !by_kind.contains(named.text())) {
        ++left_out["control"];
        continue;
      }
      auto& count = by_kind[named.text()];
      count.passed += slot.passed;
      count.dropped += slot.dropped;
    }
  }
  for (const auto& [labels, count] : by_kind) {
    passed.add(Labels::made(labels), count.passed);
    dropped.add(Labels::made(labels), count.dropped);
  }
  for (const auto* family : {&room, &masked, &masked_room, &passed, &dropped})
    family->append_to(page);
}

}  // namespace mlcca::exporter
