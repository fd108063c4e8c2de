// SPDX-License-Identifier: BSD-2-Clause
// What the gateway looks at by itself, in rounds, and what it tells of all that happens.
#include <fmt/core.h>
#include <linux/can.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "bpf/gate.h"
#include "core/model/text.hpp"
#include "daemon/gateway/gateway.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/ports/gates_lock.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kTryAgain = 10'000'000'000;  // ns

// Of a piece of a round:
constexpr std::size_t kLeasesEndedTogether = 64;  // and synced together
constexpr std::size_t kHeardAtOnce = 64;          // channels

/// "123", "FD 1ABCDEF0", "0x44697374616e6365 on its way out"
std::string frame_name(const gate_sample& sample) {
  const char* const way = sample.direction == GATE_EGRESS ? " on its way out" : "";
  if (sample.format == 0) {
    enforce::Mac mac;
    std::ranges::copy(sample.mac, mac.begin());
    return fmt::format("{}{} from {}", core::format_subject(sample.subject), way,
                       enforce::sender_text(sample.station, mac));
  }
  const char* const remote = (sample.can_id & CAN_RTR_FLAG) != 0 ? "remote " : "";
  std::string format;
  if (sample.format == GATE_FD) format = "FD ";
  if (sample.format == GATE_XL) format = "XL ";
  return (sample.can_id & CAN_EFF_FLAG) != 0
             ? fmt::format("{}{}{:08X}{}", format, remote, sample.can_id & CAN_EFF_MASK, way)
             : fmt::format("{}{}{:03X}{}", format, remote, sample.can_id & CAN_SFF_MASK, way);
}

}  // namespace

/// Each of these does one thing of many, or a few that are short.
void Gateway::plan_rounds() {
  rounds_.add([this] { return look_around(); });
  rounds_.add([this] { return repair_next(); });
  rounds_.add([this] { return end_some_leases(); });
  rounds_.add([this] { return measure_some_buses(); });
  rounds_.add([this] { return look_at_some_drops(); });
  rounds_.add([this] { return drops_.tidy(); });
  rounds_.add([this] { return look_at_next_unknown(); });
  rounds_.add([this] { return look_for_next_bypass(); });
  rounds_.add([this] { return look_at_tags(); });
  rounds_.add([this] { return ask_for_tags(); });
  rounds_.add([this] { return write_some_history(); });
}

/// What does not grow with channels or ports; the rules of can-gw are read in one answer.
bool Gateway::look_around() {
  const auto again = control_.keep_pinned();
  if (unpinned_.is_new(again ? "" : "the control word is not pinned: " + again.error().text))
    log_.error(Kind::trouble, unpinned_.text());
  if (again && *again)
    log_.error(Kind::drift,
               "somebody unpinned what closes the gates when this daemon dies: it is pinned again");
  if (lock_) keep_lock();
  if (!links_.problem().empty() || ports_.in_doubt()) links_changed();
  ports_.begin_repair();
  at_gate_ = 0;
  keep_journal();
  forwarder_.look();
  aside_.look();
  if (reading_.waits() && monotonic_ns() - reading_.begun() > options_.read_limit_ns) {
    reading_.forget();
    const std::string why = "nothing was changed: " + not_read_in_time();
    log_.error(Kind::reload, why);
    end_reload(control::Error{control::ErrorKind::unreadable, why, {}});
  }
  return false;
}

void Gateway::keep_lock() {
  const auto locked = mlcca::keep_lock(lock_, options_.bpf_root);
  if (unlocked_.is_new(locked ? ""
                              : "two daemons may change the same gates: " + locked.error().text))
    log_.error(Kind::trouble, unlocked_.text());
  if (locked && *locked)
    log_.error(Kind::drift,
               "somebody removed the lock of " + options_.bpf_root + ": it is held again");
}

bool Gateway::repair_next() {
  if (const auto gate = ports_.next_gate(at_gate_)) {
    at_gate_ = *gate;
    // A client's turn in between would be told of changes that an interface without a gate ignores.
    if (!ports_.repair(*gate)) follow_world();
    return true;
  }
  at_gate_ = 0;
  if (ports_.wants_gate()) follow_world();
  return false;
}

bool Gateway::look_for_next_bypass() {
  const auto gate = ports_.next_gate(at_gate_);
  at_gate_ = gate.value_or(0);
  if (gate) ports_.look_for_bypass(*gate, monotonic_s());
  return gate.has_value();
}

bool Gateway::write_some_history() {
  if (!history_) return false;
  const bool more = patience_.wait_for([this] { return history_->flush_some(unix_ns()); });
  for (std::string& line : history_->take_troubles()) log_.warning(Kind::trouble, std::move(line));
  return more;
}

bool Gateway::end_some_leases() {
  const std::vector<core::AdmissionId> expired =
      leases_.expired(monotonic_ns(), kLeasesEndedTogether);
  if (expired.empty()) return false;
  const auto done = release(expired, "its lease ended and was not renewed");
  if (done) return true;
  log_.error(Kind::trouble, done.error().text);
  // What could not be written down stays reserved, and is tried again.
  for (const core::AdmissionId id : expired) leases_.postpone(id, kTryAgain, monotonic_ns());
  return true;
}

void Gateway::session_closed(std::uint64_t session) {
  for (auto it = held_.begin(); it != held_.end();) {
    if (it->second.erase(session) == 0 || !it->second.empty()) {
      ++it;
      continue;
    }
    const control::Request* request = stored().admissions.find(it->first);
    if (request != nullptr)
      leases_.set(it->first, lease_of(std::get<control::Admit>(request->body)), monotonic_ns());
    it = held_.erase(it);
  }
}

/// The bands of queues by priority, as the analysis has them.
void Gateway::set_bands() {
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    if (!ports_.queues_by_priority(p)) continue;
    const std::size_t network = ports_.network_number(p);
    const core::can::Schedule* bus = scene_.state->ledger().schedule(network);
    if (bus == nullptr) continue;
    const std::uint32_t queue = core::queue_of(scene_.state->system(), scene_.self, network);
    const auto bands = core::can::bands_of(bus->assumptions(), bus->messages());
    std::array<std::uint32_t, GATE_BANDS - 1> limits{};
    limits.fill(~0U);
    for (std::size_t m = 0; m < bands.size(); ++m) {
      const core::can::Message& message = bus->messages()[m];
      if (message.queue != queue || bands[m] >= limits.size()) continue;
      std::uint32_t& limit = limits[bands[m]];
      const std::uint32_t last = std::max(message.priority, message.lowest_priority);
      limit = limit == ~0U ? last : std::max(limit, last);
    }
    ports_.set_bands(p, limits);
  }
}

bool Gateway::is_measured(std::size_t port) {
  const std::size_t network = ports_.network_number(port);
  return scene_.state->ledger().schedule(network) != nullptr &&
         scene_.state->system().networks[network].bus.measured &&
         ports_.bus_counters(port).has_value();
}

/// Of one port after the other: who is heard on its bus, some channels at a time, then its load.
bool Gateway::measure_some_buses() {
  if (hearing_.description != scene_.description) hearing_ = {};
  hearing_.description = scene_.description;
  const std::size_t port = hearing_.port;
  if (port >= ports_.size()) {
    if (hearing_.changed) {
      put_conditions(*scene_.state);
      static_cast<void>(settle());
    }
    hearing_ = {};
    return false;
  }
  if (!is_measured(port)) {
    hearing_.next_port();
    return true;
  }
  const std::size_t channels = scene_.state->decisions().size();
  const std::size_t end = std::min(hearing_.channel + kHeardAtOnce, channels);
  for (; hearing_.channel < end; ++hearing_.channel)
    hear_refused(scene_.state->decisions()[hearing_.channel], port);
  if (end < channels) return true;
  hearing_.changed |= measure_bus(port, std::move(hearing_.refused));
  hearing_.next_port();
  return true;
}

/// More on a bus than was analysed: somebody sends who was not admitted, or more than he said. What
/// the gate drops has been on the bus all the same. True if that is not as it was.
bool Gateway::measure_bus(std::size_t p, std::vector<core::Heard> senders) {
  const std::size_t network = ports_.network_number(p);
  const core::can::Schedule* bus = scene_.state->ledger().schedule(network);
  const auto counters = ports_.bus_counters(p);
  if (bus == nullptr || !counters) return false;
  auto& [strangers, told, heard] = beyond_[network];
  // Expected are what was declared, the messages of the analysis, and who is known and refused.
  std::uint64_t expected =
      bus->utilisation_ppm() -
      std::min<std::uint64_t>(bus->assumptions().background, bus->utilisation_ppm()) +
      scene_.state->system().networks[network].bus.background;
  // Its frames and those of the bus are not counted at the same moment.
  for (const core::Heard& sender : senders) expected += sender.load + BusLoad::kStep;
  const std::uint32_t now = loads_[ports_.network_of(p)].measure(
      *counters, bus->assumptions().timing.bitrate, expected, monotonic_ns());
  if (now == strangers && senders == heard) return false;
  strangers = now;
  heard = std::move(senders);
  // A load that swings is told when it comes, when it goes, and when it is quite another.
  constexpr std::uint32_t large = 200'000;
  const std::uint32_t difference = told > now ? told - now : now - told;
  if ((told == 0) == (now == 0) && difference < large) return true;
  told = now;
  log_.write(
      {.kind = Kind::interface,
       .priority = now != 0 ? 4 : 5,
       .message =
           now != 0
               ? fmt::format("{} carries at least {:.1f} % more than was admitted: somebody "
                             "sends who was not, or more than he said",
                             ports_.network_of(p), now / 1e4)
               : fmt::format("{} carries no more than was admitted again", ports_.network_of(p)),
       .network = ports_.network_of(p)});
  return true;
}

/// Who sends on the bus of a port without being granted anything, as far as its gate tells them
/// apart.
void Gateway::hear_refused(const core::Decision& decision, std::size_t port) {
  const std::size_t network = ports_.network_number(port);
  const core::can::Schedule& bus = *scene_.state->ledger().schedule(network);
  const core::Place here{core::Place::Kind::network, network};
  for (const core::Verdict& v : decision.verdicts) {
    if (scene_.state->members().publisher(v.publisher).place != here ||
        !hearing_.looked_at.insert(v.publisher).second)
      continue;
    auto rules = core::gate_state(scene_.state->system(), scene_.state->members(), v, scene_.self);
    std::erase_if(rules, [port](const core::GateRule& rule) {
      return rule.entry.port != port || rule.entry.direction != core::Direction::ingress;
    });
    if (rules.empty()) continue;
    const Frames frames = ports_.frames(rules);
    const std::uint32_t load = senders_[{port, v.publisher}].measure(
        frames.passed + frames.dropped + frames.would_drop, rules.front().entry.max_length,
        bus.assumptions().timing.bitrate, monotonic_ns());
    if (load != 0 && !bus.contains(core::Ledger::key_of({v.publisher, network, core::Flow::kOwn})))
      hearing_.refused.push_back({v.publisher, load});
  }
}

void Gateway::events_came() {
  if (const auto read = events_->read(); !read) log_.error(Kind::trouble, read.error().text);
}

/// Of a slot that was given to another grant meanwhile it concerns nobody any more.
void Gateway::hear(const gate_event& event) {
  if (event.kind == GATE_E_BOUND) {
    look_at_tags();
    return;
  }
  const auto channel = scene_.state->channel_of(event.subject);
  if (!channel) return;
  for (const core::Verdict& v : scene_.state->decisions()[*channel].verdicts)
    if (v.granted &&
        ports_.is_of(event, core::gate_state(scene_.state->system(), scene_.state->members(), v,
                                             scene_.self))) {
      if (event.kind == GATE_E_MISSING) troubled_.insert(*channel);
      deliveries_.silence(v, event);
    }
}

/// A stranger that was not heard before; the kernel sees to it that there are not too many.
void Gateway::hear(const gate_sample& sample) {
  const std::string interface = links_.name_of(static_cast<int>(sample.ifindex));
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    if (ports_.interface_name(p) != interface) continue;
    log_.warning(
        Kind::dropping,
        fmt::format("a frame that names no known subject {} {} ({}): {}, {} bytes; {} so far",
                    sample.audit != 0 ? "would be dropped on" : "was dropped on", interface,
                    ports_.network_of(p), frame_name(sample), sample.len, sample.frames),
        {.network = ports_.network_of(p)});
    return;
  }
}

/// The kernel tells it, once the newcomer has its answer and holds what it was granted.
void Gateway::tell_missing_again(const core::Verdict& v) {
  const auto told = ports_.tell_again(
      core::gate_state(scene_.state->system(), scene_.state->members(), v, scene_.self));
  if (!told) log_.error(Kind::trouble, told.error().text);
}

// --- telling -------------------------------------------------------------------------------------

control::Actor Gateway::actor_of(const serve::Peer& peer) {
  return {
      .uid = peer.uid, .user = users_.of(peer.uid), .pid = static_cast<std::uint32_t>(peer.pid)};
}

}  // namespace mlcca
