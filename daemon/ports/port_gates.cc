// SPDX-License-Identifier: BSD-2-Clause
// Which gate a port needs, and has: of CAN or of Ethernet; and which slots that is to hold.
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

Result<void> Ports::hold(const net::Link& link, const PortState& port) {
  const bool silent = port.port.refused == core::Refused::silent;
  const auto ifindex = static_cast<std::uint32_t>(link.ifindex);
  if (port.kind == core::NetworkKind::can && !link.is_ethernet)
    return hold_can({.ifindex = ifindex,
                     .name = link.name,
                     .profile = port.profile,
                     .echo_by_mark = link.kind == "can",
                     .hook = {},
                     .silent = silent});
  return hold_ethernet(
      {.ifindex = ifindex, .name = link.name, .slots = ether_slots_, .hook = {}, .silent = silent});
}

/// A gate is of one profile: another one is put in its place, and starts without slots.
Result<void> Ports::hold_can(const enforce::GateConfig& config) {
  const auto ifindex = static_cast<int>(config.ifindex);
  if (const auto old = gates_.find(ifindex); old != gates_.end()) {
    if (old->second.can != nullptr && old->second.can->config().profile == config.profile &&
        old->second.can->config().echo_by_mark == config.echo_by_mark &&
        old->second.can->config().silent == config.silent)
      return {};
    gates_.erase(old);
  }
  auto attached = enforce::Gate::attach(config, control_);
  if (!attached) return std::unexpected(attached.error());
  auto gate = std::make_unique<enforce::Gate>(std::move(*attached));
  enforce::Gate* const can = gate.get();
  gates_.emplace(ifindex, Held{std::move(gate), can, nullptr});
  return {};
}

/// A gate that has become too small, or is to tell senders otherwise, is replaced by one that has
/// its slots.
Result<void> Ports::hold_ethernet(const enforce::EtherConfig& config) {
  const auto ifindex = static_cast<int>(config.ifindex);
  if (const auto old = gates_.find(ifindex); old != gates_.end()) {
    if (old->second.ethernet != nullptr && old->second.ethernet->holds(config)) return {};
    gates_.erase(old);
  }
  auto attached = enforce::EtherGate::attach(config, control_);
  if (!attached) return std::unexpected(attached.error());
  auto gate = std::make_unique<enforce::EtherGate>(std::move(*attached));
  enforce::EtherGate* const ethernet = gate.get();
  gates_.emplace(ifindex, Held{std::move(gate), nullptr, ethernet});
  return {};
}

const enforce::PortGate* Ports::gate_of(std::size_t port) const {
  const auto it = gates_.find(ports_[port].ifindex);
  return it == gates_.end() || !needs_gate(ports_[port]) ? nullptr : it->second.gate.get();
}
enforce::PortGate* Ports::gate_of(std::size_t port) {
  return const_cast<enforce::PortGate*>(
      std::as_const(*this).gate_of(port));  // NOLINT(*-const-cast)
}
enforce::Gate* Ports::can_gate_of(std::size_t port) const {
  return gate_of(port) == nullptr ? nullptr : gates_.at(ports_[port].ifindex).can;
}

std::vector<enforce::PlacedSlot> Ports::slots(std::span<const core::GateRule> rules) const {
  std::vector<enforce::PlacedSlot> placed;
  for (const core::GateRule& rule : rules)
    if (const enforce::PortGate* gate = gate_of(rule.entry.port))
      if (const auto slot = slot_of(rule)) placed.push_back({gate->ifindex(), *slot});
  return placed;
}

}  // namespace mlcca
