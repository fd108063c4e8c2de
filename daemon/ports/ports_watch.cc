// SPDX-License-Identifier: BSD-2-Clause
// How events come to the gates of this gateway.
#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "bpf/ether.h"
#include "core/profiles/profile.hpp"
#include "daemon/ports/ports.hpp"

namespace mlcca {
namespace {

control::Watch report_of(const core::Watching& expected, const enforce::Arrivals& found) {
  return {.period_ns = expected.period,
          .timeout_ns = expected.silence,
          .missing_now = found.silent,
          .events = found.events,
          .missing = found.missing,
          .since_last_ns = found.since_last,
          .last_gap_ns = found.last_gap,
          .shortest_gap_ns = found.shortest,
          .longest_gap_ns = found.longest,
          .jitter_ns = found.jitter,
          .rate_mhz = found.rate,
          .gaps = {std::begin(found.gaps), std::end(found.gaps)}};
}

}  // namespace

/// The slot that the events of a delivery enter by, if they are watched.
std::optional<Ports::WatchedSlot> Ports::watched_slot(const core::GateState& rules) const {
  for (const core::GateRule& rule : rules) {
    const enforce::PortGate* gate = gate_of(rule.entry.port);
    const auto slot = slot_of(rule);
    if (gate == nullptr || !slot || slot->period == 0) continue;
    if (const auto number = gate->watched_as(*slot))
      return WatchedSlot{gate, *number, rule.watching};
  }
  return std::nullopt;
}

std::optional<control::Watch> Ports::watch(const core::GateState& rules) const {
  const auto slot = watched_slot(rules);
  if (!slot) return std::nullopt;
  return report_of(slot->expected, slot->gate->arrivals(slot->number, monotonic_ns()));
}

Result<void> Ports::report_again(const core::GateState& rules) const {
  const auto slot = watched_slot(rules);
  return slot ? slot->gate->report_again(slot->number) : Result<void>{};
}

bool Ports::is_of(const gate_event& event, const core::GateState& rules) const {
  return std::ranges::any_of(rules, [&](const core::GateRule& rule) {
    const enforce::PortGate* gate = gate_of(rule.entry.port);
    const auto slot = slot_of(rule);
    return gate != nullptr && slot && gate->ifindex() == event.ifindex &&
           rule.entry.subject == event.subject && gate->watched_as(*slot) == event.slot;
  });
}

/// Reported when it begins and when it ends.
void Ports::report_unwatched() {
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::PortGate* gate = gate_of(p);
    const bool now = gate != nullptr && gate->unwatched() != 0;
    if (std::exchange(ports_[p].unwatched, now) == now) continue;
    report_(ports_[p].network_name,
            now ? fmt::format("{} has {} periodic channels more than can be watched ({}): missing "
                              "events of these are not detected",
                              gate->name(), gate->unwatched(), ETHER_WATCHES - 1)
                : fmt::format("{}: every periodic channel is watched again", interface_name(p)),
            now);
  }
}

std::optional<enforce::Bindings> Ports::bindings(std::size_t port) const {
  const enforce::Gate* gate = can_gate_of(port);
  if (gate == nullptr || !core::traits_of(ports_[port].profile).deals_tags) return std::nullopt;
  return gate->bindings();
}

}  // namespace mlcca
