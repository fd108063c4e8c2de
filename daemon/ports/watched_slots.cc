// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/watched_slots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "base/clock.hpp"
#include "bpf/ether.h"
#include "daemon/ports/gate_slots.hpp"

namespace mlcca {
namespace {

/// The gate counts for the subscriber with the shortest timeout. For one with a longer timeout
/// nothing is missing yet.
bool is_missing(const core::Watching& expected, const gates::Arrivals& found) {
  if (!found.silent || expected.silence == 0) return false;
  return expected.silence <= found.silence || found.since_last >= expected.silence;
}

control::Watch report_of(const core::Watching& expected, const gates::Arrivals& found) {
  return {.period_ns = expected.period,
          .timeout_ns = expected.silence,
          .missing_now = is_missing(expected, found),
          .events = found.events,
          .missing = found.missing,
          .since_last_ns = found.since_last,
          .last_gap_ns = found.last_gap,
          .shortest_gap_ns = found.shortest,
          .longest_gap_ns = found.longest,
          .jitter_ns = found.jitter,
          .rate_millihertz = found.rate,
          .gaps = {std::begin(found.gaps), std::end(found.gaps)}};
}

struct WatchedSlot {
  const gates::PortGate* gate;
  std::uint32_t number;
  core::Watching expected;
};

/// The slot by which the events of a delivery enter, if they are watched; nullopt otherwise.
std::optional<WatchedSlot> watched_slot(const core::GateState& rules, const GatedPorts& ports) {
  for (const core::GateRule& rule : rules) {
    const gates::PortGate* gate = ports.gate(rule.entry.port);
    const auto slot = slot_of(rule, ports);
    if (gate == nullptr || !slot || slot->period == 0) continue;
    if (const auto number = gate->watched_as(*slot))
      return WatchedSlot{gate, *number, rule.watching};
  }
  return std::nullopt;
}

}  // namespace

std::optional<control::Watch> watch_of(const core::GateState& rules, const GatedPorts& ports) {
  const auto slot = watched_slot(rules, ports);
  if (!slot) return std::nullopt;
  return report_of(slot->expected, slot->gate->arrivals(slot->number, monotonic_ns()));
}

Result<void> report_missing_again(const core::GateState& rules, const GatedPorts& ports) {
  const auto slot = watched_slot(rules, ports);
  return slot ? slot->gate->report_again(slot->number) : Result<void>{};
}

bool is_of(const gate_event& event, const core::GateState& rules, const GatedPorts& ports) {
  return std::ranges::any_of(rules, [&](const core::GateRule& rule) {
    const gates::PortGate* gate = ports.gate(rule.entry.port);
    const auto slot = slot_of(rule, ports);
    return gate != nullptr && slot && slot->period != 0 && gate->ifindex() == event.ifindex &&
           rule.entry.subject == event.subject && gate->watched_as(*slot) == event.slot;
  });
}

void report_unwatched(GatedPorts& ports, const net::InterfaceTable& links,
                      const ReportLine& report) {
  std::size_t p = 0;
  for (GatedPort& gated : ports) {
    const gates::PortGate* gate = ports.gate(p++);
    const bool now = gate != nullptr && gate->unwatched() != 0;
    if (std::exchange(gated.unwatched, now) == now) continue;
    report(gated.port.network(),
           now ? fmt::format("{} has {} periodic channels more than can be watched ({}): missing "
                             "events of these are not detected",
                             gate->name(), gate->unwatched(), ETHER_WATCHES - 1)
               : fmt::format("{}: every periodic channel is watched again",
                             gated.port.interface_name(links)),
           now);
  }
}

}  // namespace mlcca
