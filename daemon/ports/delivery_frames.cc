// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/delivery_frames.hpp"

#include <algorithm>

#include "daemon/ports/gate_slots.hpp"

namespace mlcca {
namespace {

core::Direction counted_direction(const core::GateState& rules,
                                  const std::vector<core::GateEntry>& shared) {
  const auto any = [&rules](core::Direction direction, auto&& is_meant) {
    return std::ranges::any_of(rules, [&](const core::GateRule& r) {
      return r.entry.direction == direction && is_meant(r.entry);
    });
  };
  const auto is_own = [&shared](const core::GateEntry& entry) {
    return !std::ranges::binary_search(shared, entry);
  };
  const bool leaves = any(core::Direction::egress, [](const auto&) { return true; });
  const bool counted_out =
      leaves && (any(core::Direction::egress, is_own) || !any(core::Direction::ingress, is_own));
  return counted_out ? core::Direction::egress : core::Direction::ingress;
}

}  // namespace

Frames delivery_frames(const core::GateState& rules, const std::vector<core::GateEntry>& shared,
                       const CountersOf& counters_of) {
  const core::Direction counts = counted_direction(rules, shared);
  Frames sum;
  for (const core::GateRule& rule : rules) {
    const auto counted = counters_of(rule);
    if (!counted) continue;
    sum.dropped += counted->dropped;
    sum.would_drop += counted->would_drop;
    sum.would_exceed += counted->would_exceed;
    sum.excess += counted->excess + counted->would_exceed;
    if (!rule.policing.counts_only) sum.excess_dropped += counted->excess;
    if (rule.entry.direction == counts) sum.passed += counted->passed;
    if (counted->last_reason != core::FrameReason::passed) sum.last_reason = counted->last_reason;
  }
  return sum;
}

Frames delivery_frames(const core::GateState& rules, const std::vector<core::GateEntry>& shared,
                       const GatedPorts& ports) {
  return delivery_frames(
      rules, shared, [&ports](const core::GateRule& rule) -> std::optional<gates::SlotCounters> {
        const gates::PortGate* gate = ports.gate(rule.entry.port);
        if (gate == nullptr) return std::nullopt;
        const auto slot = slot_of(rule.entry, ports);
        return slot ? gate->counters(*slot) : std::nullopt;
      });
}

}  // namespace mlcca
