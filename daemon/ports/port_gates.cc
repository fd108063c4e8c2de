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

namespace {

bool is_by_can_gate(const net::Link& link, core::NetworkKind kind) {
  return kind == core::NetworkKind::can && !link.is_ethernet;
}

enforce::GateConfig can_config(const net::Link& link, core::Profile profile, bool silent) {
  return {.ifindex = static_cast<std::uint32_t>(link.ifindex),
          .name = link.name,
          .profile = profile,
          .echo_by_mark = link.kind == "can",
          .hook = {},
          .silent = silent};
}

enforce::EtherConfig ether_config(const net::Link& link, std::size_t slots, bool silent) {
  return {.ifindex = static_cast<std::uint32_t>(link.ifindex),
          .name = link.name,
          .slots = slots,
          .hook = {},
          .silent = silent};
}

}  // namespace

/// A gate is of one profile.
bool Ports::Held::holds(const enforce::GateConfig& config) const {
  return can != nullptr && can->config().profile == config.profile &&
         can->config().echo_by_mark == config.echo_by_mark && can->config().silent == config.silent;
}
bool Ports::Held::holds(const enforce::EtherConfig& config) const {
  return ethernet != nullptr && ethernet->holds(config);
}

Result<Ports::Held> Ports::load(const enforce::GateConfig& config) const {
  auto loaded = enforce::Gate::load(config, control_);
  if (!loaded) return std::unexpected(loaded.error());
  auto gate = std::make_unique<enforce::Gate>(std::move(*loaded));
  enforce::Gate* const can = gate.get();
  return Held{std::move(gate), can, nullptr};
}
Result<Ports::Held> Ports::load(const enforce::EtherConfig& config) const {
  auto loaded = enforce::EtherGate::load(config, control_);
  if (!loaded) return std::unexpected(loaded.error());
  auto gate = std::make_unique<enforce::EtherGate>(std::move(*loaded));
  enforce::EtherGate* const ethernet = gate.get();
  return Held{std::move(gate), nullptr, ethernet};
}

Result<void> Ports::hold(const net::Link& link, const PortState& port) {
  if (!change_) return change_;  // it goes back to what was
  const bool silent = port.port.refused == core::Refused::silent;
  auto done = is_by_can_gate(link, port.kind) ? hold(can_config(link, port.profile, silent))
                                              : hold(ether_config(link, ether_slots_, silent));
  // There is no way back from the way back: what cannot be held then is closed, as ever.
  if (!done && keeps_spares_ && !goes_back_ && change_) change_ = done;
  return done;
}

/// The gate that is there goes when the other one is in its place: one of another profile, one that
/// has become too small, whose slots the other one has, or one that answers senders otherwise.
template <class Config>
Result<void> Ports::hold(const Config& config) {
  const auto ifindex = static_cast<int>(config.ifindex);
  const auto old = gates_.find(ifindex);
  if (old != gates_.end() && old->second.holds(config)) return {};
  const auto [first, last] = spares_.equal_range(ifindex);
  auto spare =
      std::find_if(first, last, [&](const auto& entry) { return entry.second.holds(config); });
  if (spare == last) {
    auto made = load(config);
    if (!made) return std::unexpected(made.error());
    spare = spares_.emplace(ifindex, std::move(*made));
  }
  if (auto put = spare->second->put(); !put) {
    // What cannot be put back is found by repair().
    if (old != gates_.end()) static_cast<void>(old->second->reattach());
    if (!keeps_spares_) spares_.erase(spare);
    return put;
  }
  Held held = std::move(spare->second);
  spares_.erase(spare);
  if (old == gates_.end()) {
    gates_.emplace(ifindex, std::move(held));
  } else {
    std::swap(old->second, held);
    if (keeps_spares_) spares_.emplace(ifindex, std::move(held));
  }
  return {};
}

Result<void> Ports::make_spare(const net::Link& link, const PortState& port, std::size_t slots) {
  const bool silent = port.port.refused == core::Refused::silent;
  const auto old = gates_.find(link.ifindex);
  const auto make = [&](const auto& config) -> Result<void> {
    if (old != gates_.end() && old->second.holds(config)) return {};
    auto made = load(config);
    if (!made) return std::unexpected(made.error());
    spares_.emplace(link.ifindex, std::move(*made));
    return {};
  };
  return is_by_can_gate(link, port.kind) ? make(can_config(link, port.profile, silent))
                                         : make(ether_config(link, slots, silent));
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
    if (auto made = make_spare(link, port, ether_slots_of(system)); !made && !is_lacking) {
      end_change();
      return made;
    }
    step_();
  }
  keeps_spares_ = true;
  change_ = {};
  return {};
}

void Ports::end_change() {
  spares_.clear();
  keeps_spares_ = false;
  goes_back_ = false;
  change_ = {};
}

/// Those that may be put in its place as well: they may read its slots, or have a copy.
void Ports::deny(int ifindex) {
  if (const auto gate = gates_.find(ifindex); gate != gates_.end()) gate->second->deny_all();
  const auto [first, last] = spares_.equal_range(ifindex);
  std::for_each(first, last, [](const auto& spare) { spare.second->deny_all(); });
}

/// The facts of each interface are read once, not for every port.
net::FactsOf Ports::facts_once() const {
  return [this, known = std::make_shared<std::map<int, net::UdevFacts>>()](int ifindex) {
    const auto [it, fresh] = known->try_emplace(ifindex);
    if (fresh) it->second = facts_of_(ifindex);
    return it->second;
  };
}

const enforce::PortGate* Ports::gate_of(std::size_t port) const {
  const auto it = gates_.find(ports_[port].ifindex);
  return it == gates_.end() || !needs_gate(ports_[port]) || ports_[port].unfit
             ? nullptr
             : it->second.gate.get();
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
