// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/gate_slots.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "bpf/ether.h"
#include "bpf/gate.h"
#include "core/model/progress.hpp"
#include "daemon/gates/entry_slot.hpp"

namespace mlcca {

static_assert(core::kMostEntries == ETHER_CHAIN);
static_assert(core::kMostBusEntries == GATE_CHAIN);

namespace {

/// The index of the interface of the source port; 0 if the entry has none; nullopt if that
/// interface is not there.
std::optional<std::uint32_t> source_of(const core::GateEntry& entry, const GatedPorts& ports) {
  if (!entry.source_port) return 0;
  const int ifindex = ports[*entry.source_port].ifindex();
  if (ifindex == 0) return std::nullopt;
  return static_cast<std::uint32_t>(ifindex);
}

/// `from` is the entry or its rule.
template <class From>
std::optional<gates::SlotSpec> slot_from(const From& from, const core::GateEntry& entry,
                                         const GatedPorts& ports) {
  const auto source = source_of(entry, ports);
  if (!source) return std::nullopt;
  return gates::slot_of(from, ports[entry.port].kind(), *source);
}

using ByPort = std::map<std::size_t, gates::SlotChanges>;
using Slots = std::vector<gates::SlotSpec>;

/// Adds slots to one list of the changes of each port. `from`: entries or rules.
template <class From, class EntryOf>
void spread(const std::vector<From>& from, const EntryOf& entry_of,
            Slots gates::SlotChanges::* list, const GatedPorts& ports, ByPort& to) {
  for (const From& one : from) {
    const std::size_t port = std::invoke(entry_of, one).port;
    if (ports.has_gate(port))
      if (auto slot = slot_of(one, ports)) (to[port].*list).push_back(*slot);
    core::Progress::step();
  }
}

std::vector<Slots> slots_by_port(const core::GateState& rules, const GatedPorts& ports) {
  std::vector<Slots> slots(ports.size());
  for (const core::GateRule& rule : rules) {
    if (ports.has_gate(rule.entry.port))
      if (auto slot = slot_of(rule, ports)) slots[rule.entry.port].push_back(*slot);
    core::Progress::step();
  }
  return slots;
}

}  // namespace

std::optional<gates::SlotSpec> slot_of(const core::GateEntry& entry, const GatedPorts& ports) {
  return slot_from(entry, entry, ports);
}

std::optional<gates::SlotSpec> slot_of(const core::GateRule& rule, const GatedPorts& ports) {
  return slot_from(rule, rule.entry, ports);
}

std::optional<std::uint32_t> slot_number_of(const core::GateEntry& entry, const GatedPorts& ports) {
  const gates::PortGate* const gate = ports.gate(entry.port);
  const auto slot = slot_of(entry, ports);
  return gate == nullptr || !slot ? std::nullopt : gate->number_of(*slot);
}

ByPort changes_by_port(const core::GateChanges& changes, const GatedPorts& ports) {
  ByPort out;
  spread(changes.close, std::identity{}, &gates::SlotChanges::close, ports, out);
  spread(changes.remove, std::identity{}, &gates::SlotChanges::remove, ports, out);
  spread(changes.open, std::identity{}, &gates::SlotChanges::open, ports, out);
  spread(changes.add, &core::GateRule::entry, &gates::SlotChanges::add, ports, out);
  spread(changes.police, &core::GateRule::entry, &gates::SlotChanges::police, ports, out);
  return out;
}

std::vector<gates::PlacedSlot> placed_slots(std::span<const core::GateRule> rules,
                                            const GatedPorts& ports) {
  std::vector<gates::PlacedSlot> placed;
  for (const core::GateRule& rule : rules)
    if (const gates::PortGate* gate = ports.gate(rule.entry.port))
      if (const auto slot = slot_of(rule, ports)) placed.push_back({gate->ifindex(), *slot});
  return placed;
}

Result<void> hold_exactly(const core::GateState& wanted, const GatedPorts& ports) {
  const std::vector<Slots> slots = slots_by_port(wanted, ports);
  std::vector<gates::PortGate::Change> changes;
  for (std::size_t p = 0; p < ports.size(); ++p) {
    gates::PortGate* const gate = ports.gate(p);
    if (gate == nullptr) continue;
    if (auto change = gates::slot_changes_between(gate->present(), slots[p]); !change.empty())
      changes.push_back({gate, std::move(change)});
    core::Progress::made();
  }
  std::string problems;
  for (;;) {
    const auto done = gates::PortGate::apply_together(changes);
    if (done) break;
    gates::PortGate* const refusing = done.error().gate;
    refusing->deny_all();
    problems += (problems.empty() ? "" : "; ") + refusing->name() + ": " + done.error().error.text;
    std::erase_if(changes, [&](const auto& c) { return c.gate == refusing; });
  }
  if (!problems.empty()) return fail(problems);
  return {};
}

Result<void> make_changes(const core::GateChanges& changes, const GatedPorts& ports) {
  std::vector<gates::PortGate::Change> gates;
  for (auto& [p, change] : changes_by_port(changes, ports))
    gates.push_back({ports.gate(p), std::move(change)});
  if (const auto done = gates::PortGate::apply_together(gates); !done)
    return fail(done.error().gate->name() + ": " + done.error().error.text);
  return {};
}

}  // namespace mlcca
