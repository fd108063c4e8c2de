// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/gate_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/can.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <vector>

#include "bpf/ether.h"
#include "bpf/gate.h"
#include "core/gates/control_traffic.hpp"
#include "core/model/text.hpp"
#include "core/model/words.hpp"

namespace mlcca {
namespace {

/// The slots of channels of one gate that are listed. It may have a thousand times as many.
constexpr std::size_t kListed = GATE_SLOTS;

auto place_of(const gates::SlotSpec& s) {
  return std::tuple(s.direction, s.id, s.mask, s.source, s.uid, s.origin, s.subject, s.station);
}

/// Leaves the first `count` of them, in order.
void keep_first(std::size_t count, std::vector<gates::SlotSpec>& slots) {
  const auto end = slots.begin() + static_cast<std::ptrdiff_t>(count);
  std::ranges::partial_sort(slots, end, {}, place_of);
  slots.erase(end, slots.end());
}

std::string formats_of(std::uint8_t formats, bool can) {
  std::string words;
  const auto add = [&](unsigned format, const char* word) {
    if ((formats & format) != 0) words.append(words.empty() ? "" : " ").append(word);
  };
  if (can) {
    add(GATE_CLASSIC, "classic");
    add(GATE_FD, "fd");
    add(GATE_XL, "xl");
    add(GATE_TRANSPORT, "transport");
  } else {
    add(ETHER_UNFRAGMENTED, "unfragmented");
    add(ETHER_FRAGMENT, "fragments");
  }
  return words;
}

/// The traffic that an Ethernet gate passes without a subject.
control::GateSlot left_alone(const gates::PortGate& gate, gates::Direction direction,
                             gate_reason reason) {
  control::GateSlot out;
  out.name = core::to_text(gates::reason_of(reason));
  out.egress = direction == gates::Direction::egress;
  out.passes = true;
  out.passed = gate.reasons(direction)[reason];
  return out;
}

class GateReport {
 public:
  GateReport(const GatedPorts& ports, const net::InterfaceTable& links, const core::State& state)
      : ports_(ports), links_(links), state_(state) {}

  [[nodiscard]] control::Gate gate_of(std::size_t p) const {
    control::Gate out;
    out.interface = ports_[p].interface_name(links_);
    out.network = ports_[p].network();
    out.profile = core::words::kProfiles.of(ports_[p].profile());
    out.problem = ports_[p].problem();
    const bool can = ports_[p].is_can();
    out.masked_slots_limit = can ? GATE_WALK : 0;
    const gates::PortGate* gate = ports_.gate(p);
    if (gate == nullptr) gate = ports_.closed_gate(p);
    if (gate == nullptr) return out;
    out.attached = gate->attached().value_or(false);
    out.slots_limit = static_cast<std::uint32_t>(gate->room());
    const auto slots = gate->present();
    out.slots = static_cast<std::uint32_t>(slots.size());
    std::array<std::uint32_t, 2> masked{};
    for (const gates::SlotSpec& slot : slots)
      if (gate->is_masked(slot)) ++masked.at(static_cast<std::size_t>(slot.direction));
    out.masked_slots = std::ranges::max(masked);
    const auto of_control = [this, p](const gates::SlotSpec& slot) { return is_control(slot, p); };
    for (const gates::SlotSpec& slot : listed_slots(slots, kListed, of_control)) {
      auto& list = of_control(slot) ? out.control : out.channels;
      list.push_back(slot_of(*gate, slot, p));
    }
    if (!can)
      for (const auto direction : {gates::Direction::ingress, gates::Direction::egress})
        out.control.push_back(left_alone(*gate, direction, GATE_R_FOREIGN));
    if (!can) out.control.push_back(left_alone(*gate, gates::Direction::ingress, GATE_R_ECHO));
    return out;
  }

 private:
  [[nodiscard]] control::GateSlot slot_of(const gates::PortGate& gate, const gates::SlotSpec& slot,
                                          std::size_t port) const {
    control::GateSlot out;
    out.name = name_of(slot, port);
    out.egress = slot.direction == gates::Direction::egress;
    out.passes = slot.pass;
    out.id = slot.id;
    out.mask = slot.mask;
    out.formats = formats_of(slot.formats, ports_[port].is_can());
    out.max_length = slot.max_len;
    out.source = source_of(slot);
    out.per_frame_ns = slot.per_frame;
    out.per_byte = slot.per_byte;
    out.tolerance_ns = slot.tolerance;
    out.excess_passes = slot.excess_passes;
    if (const auto counted = gate.counters(slot)) {
      out.passed = counted->passed;
      out.dropped = counted->dropped;
      out.excess = counted->excess + counted->would_exceed;
      out.would_drop = counted->would_drop;
      out.would_exceed = counted->would_exceed;
      out.bytes = counted->bytes;
      if (counted->last_reason != core::FrameReason::passed)
        out.last_reason = core::to_text(counted->last_reason);
    }
    return out;
  }

  [[nodiscard]] bool is_control(const gates::SlotSpec& slot, std::size_t port) const {
    if (ports_[port].is_can()) return slot.subject == core::kControlSubject;
    return slot.subject == core::kSubscribeSubject && !state_.channel_of(slot.subject);
  }

  [[nodiscard]] std::string name_of(const gates::SlotSpec& slot, std::size_t port) const {
    if (is_control(slot, port))
      return ports_[port].is_can()
                 ? std::string(core::control_kind_of(ports_[port].profile(), slot.id, slot.mask))
                 : "subscribe";
    const auto channel = state_.channel_of(slot.subject);
    return channel ? state_.system().channels[*channel].name : fmt::format("{:#x}", slot.subject);
  }

  [[nodiscard]] std::string source_of(const gates::SlotSpec& slot) const {
    std::string station = core::to_text(core::Station{slot.station});
    if (slot.direction == gates::Direction::ingress) return station;
    const std::string way = way_of(slot);
    return station.empty() ? way : station + " by " + way;
  }

  /// The source of frames that leave.
  [[nodiscard]] std::string way_of(const gates::SlotSpec& slot) const {
    if (slot.source == GATE_NO_SOURCE) return "kernel";
    if (slot.source == 0)
      return slot.uid == GATE_ANY_UID ? "any user" : fmt::format("user {}", slot.uid);
    for (std::size_t p = 0; p < ports_.size(); ++p)
      if (const auto* gate = ports_.gate(p); gate != nullptr && gate->ifindex() == slot.source)
        return gate->name() + identifier_at(*gate, slot);
    return fmt::format("interface {}", slot.source);
  }

  /// The identifier with which a frame came in, if it leaves with another one; otherwise empty.
  [[nodiscard]] std::string identifier_at(const gates::PortGate& gate,
                                          const gates::SlotSpec& slot) const {
    if (slot.origin == 0) return {};
    const auto [at, fresh] = entered_.try_emplace(gate.ifindex());
    if (fresh)
      for (const gates::SlotSpec& s : gate.present())
        if (s.direction == gates::Direction::ingress) at->second.emplace(s.origin, s.id);
    const auto id = at->second.find(slot.origin);
    if (id == at->second.end() || id->second == slot.id) return {};
    const bool extended = (id->second & CAN_EFF_FLAG) != 0;
    return fmt::format(" as {:0{}x}", id->second & (extended ? CAN_EFF_MASK : CAN_SFF_MASK),
                       extended ? 8 : 3);
  }

  using Identifiers = std::map<std::uint32_t, std::uint32_t>;  // by origin

  const GatedPorts& ports_;
  const net::InterfaceTable& links_;
  const core::State& state_;
  mutable std::map<std::uint32_t, Identifiers> entered_;  ///< by interface index
};

bool has_report(const GatedPorts& ports, std::size_t port) {
  return ports[port].needs_gate() || ports.closed_gate(port) != nullptr;
}

}  // namespace

std::vector<gates::SlotSpec> listed_slots(
    const std::vector<gates::SlotSpec>& slots, std::size_t most,
    const std::function<bool(const gates::SlotSpec&)>& is_control) {
  std::vector<gates::SlotSpec> control;
  std::vector<gates::SlotSpec> entering;
  std::vector<gates::SlotSpec> leaving;
  for (const gates::SlotSpec& slot : slots) {
    auto& of_channels = slot.direction == gates::Direction::ingress ? entering : leaving;
    (is_control(slot) ? control : of_channels).push_back(slot);
  }
  const std::size_t in = std::min(entering.size(), most - std::min(leaving.size(), most / 2));
  keep_first(control.size(), control);
  keep_first(in, entering);
  keep_first(std::min(leaving.size(), most - in), leaving);
  control.insert(control.end(), entering.begin(), entering.end());
  control.insert(control.end(), leaving.begin(), leaving.end());
  return control;
}

control::Gates gate_reports(const GatedPorts& ports, const net::InterfaceTable& links,
                            const core::State& state, const std::string& place) {
  control::Gates out;
  const GateReport report(ports, links, state);
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (has_report(ports, p) &&
        (place.empty() || place == ports[p].network() || place == ports[p].interface_name(links)))
      out.gates.push_back(report.gate_of(p));
  return out;
}

std::string gated_places(const GatedPorts& ports, const net::InterfaceTable& links) {
  std::vector<std::string> names;
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (has_report(ports, p))
      names.push_back(fmt::format("{} of {}", ports[p].interface_name(links), ports[p].network()));
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::size_t slot_count(const GatedPorts& ports) {
  std::size_t slots = 0;
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (const auto* gate = ports.gate(p)) slots += gate->size();
  return slots;
}

}  // namespace mlcca
