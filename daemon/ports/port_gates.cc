// SPDX-License-Identifier: BSD-2-Clause
// Which gate a port needs, and has: of CAN or of Ethernet; and which slots that is to hold.
#include <algorithm>
#include <memory>
#include <utility>

#include "daemon/ports/ports.hpp"

namespace mlcca {

bool Ports::needs_gate(const PortState& port) { return port.profile != core::Profile::none; }

bool Ports::is_gated_can(const PortState& port) {
  return port.kind == core::NetworkKind::can && needs_gate(port);
}

bool Ports::can_have_gate(const PortState& port, const net::Link& link) {
  if (!needs_gate(port)) return false;
  return port.kind == core::NetworkKind::can ? link.is_can : link.is_ethernet;
}

Result<void> Ports::prepare(const core::System& system, std::size_t gateway) {
  const net::FactsOf facts_of = facts_once();
  for (const PortState& port : ports_of(system, gateway)) {
    const auto found = net::find_interface(port.port.identity, links_.table(), facts_of);
    if (!found || !*found) continue;
    const net::Link& link = links_.table().at(**found);
    if (!can_have_gate(port, link)) continue;
    // What has no gate although it ought to have one gets no worse.
    const bool is_lacking = is_to_be_gated(link.ifindex) && !gates_.contains(link.ifindex);
    const auto spec =
        gate_spec(link, port.kind, port.profile, port.port.refused, ether_slots_of(system));
    if (auto made = gates_.make_spare(spec); !made && !is_lacking) {
      gates_.end_change();
      return made;
    }
    step_();
  }
  gates_.begin_change();
  return {};
}

/// The facts of each interface are read once, not for every port.
net::FactsOf Ports::facts_once() const {
  return [this, known = std::make_shared<std::map<int, net::UdevFacts>>()](int ifindex) {
    const auto [it, fresh] = known->try_emplace(ifindex);
    if (fresh) it->second = facts_of_(ifindex);
    return it->second;
  };
}

HeldGate* Ports::held_by(std::size_t port) const {
  const PortState& state = ports_[port];
  return needs_gate(state) && !state.unfit ? gates_.find(state.ifindex) : nullptr;
}
enforce::PortGate* Ports::gate_of(std::size_t port) const {
  HeldGate* const held = held_by(port);
  return held == nullptr ? nullptr : &held->port_gate();
}
enforce::Gate* Ports::can_gate_of(std::size_t port) const {
  HeldGate* const held = held_by(port);
  return held == nullptr ? nullptr : held->can_gate();
}

std::vector<enforce::PlacedSlot> Ports::slots(std::span<const core::GateRule> rules) const {
  std::vector<enforce::PlacedSlot> placed;
  for (const core::GateRule& rule : rules)
    if (const enforce::PortGate* gate = gate_of(rule.entry.port))
      if (const auto slot = slot_of(rule)) placed.push_back({gate->ifindex(), *slot});
  return placed;
}

}  // namespace mlcca
