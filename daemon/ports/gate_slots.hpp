// SPDX-License-Identifier: BSD-2-Clause
// From what a plan says of ports to the slots of their gates.
#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// Nothing: the frames would come from an interface that is not there.
[[nodiscard]] std::optional<enforce::SlotSpec> slot_of(const core::GateEntry& entry,
                                                       const GatedPorts& ports);
[[nodiscard]] std::optional<enforce::SlotSpec> slot_of(const core::GateRule& rule,
                                                       const GatedPorts& ports);
/// Of those ports that have a gate.
[[nodiscard]] std::map<std::size_t, enforce::SlotChanges> changes_by_port(
    const core::GateChanges& changes, const GatedPorts& ports);
/// What the gates hold of these rules, in their order.
[[nodiscard]] std::vector<enforce::PlacedSlot> placed_slots(std::span<const core::GateRule> rules,
                                                            const GatedPorts& ports);

/// Makes every gate hold exactly `wanted`. A gate that refuses is denied as a whole, and the error
/// names it.
Result<void> hold_exactly(const core::GateState& wanted, const GatedPorts& ports);
/// After an error gates hold part of the changes.
Result<void> make_changes(const core::GateChanges& changes, const GatedPorts& ports);

}  // namespace mlcca
