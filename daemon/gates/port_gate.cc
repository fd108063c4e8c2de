// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/port_gate.hpp"

#include <utility>

#include "core/model/progress.hpp"

namespace mlcca::enforce {

Result<void> PortGate::arm_what_is_new() {
  for (const std::uint16_t watch : table().take_newly_watched()) {
    if (auto armed = arm(watch); !armed) return armed;
    core::Progress::made();
  }
  return {};
}

Result<void> PortGate::apply(const SlotChanges& changes) {
  if (auto applied = table().apply(changes); !applied) return applied;
  return arm_what_is_new();
}

std::expected<void, PortGate::Refusal> PortGate::apply_together(std::span<const Change> changes) {
  std::vector<Table::Change> tables;
  tables.reserve(changes.size());
  for (const Change& c : changes) tables.push_back({&c.gate->table(), &c.changes});
  if (auto done = Table::apply_together(tables); !done)
    return std::unexpected(
        Refusal{changes[done.error().change].gate, std::move(done.error().error)});
  for (const Change& c : changes)
    if (auto armed = c.gate->arm_what_is_new(); !armed)
      return std::unexpected(Refusal{c.gate, std::move(armed.error())});
  return {};
}

}  // namespace mlcca::enforce
