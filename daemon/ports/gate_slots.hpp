// SPDX-License-Identifier: BSD-2-Clause
// Turns the plan of a gateway into slots of the gates of its ports.
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

/// nullopt if the frames would come from an interface that is not there.
[[nodiscard]] std::optional<gates::SlotSpec> slot_of(const core::GateEntry& entry,
                                                     const GatedPorts& ports);
[[nodiscard]] std::optional<gates::SlotSpec> slot_of(const core::GateRule& rule,
                                                     const GatedPorts& ports);
/// The number of the slot of an entry in the gate of its port; nullopt if it has none.
[[nodiscard]] std::optional<std::uint32_t> slot_number_of(const core::GateEntry& entry,
                                                          const GatedPorts& ports);
/// The changes of the gates, for those ports that have one.
[[nodiscard]] std::map<std::size_t, gates::SlotChanges> changes_by_port(
    const core::GateChanges& changes, const GatedPorts& ports);
/// The slots of the gates for these rules, in the order of the rules.
[[nodiscard]] std::vector<gates::PlacedSlot> placed_slots(std::span<const core::GateRule> rules,
                                                          const GatedPorts& ports);

/// Makes every gate hold exactly `wanted`. A gate whose change the kernel refuses denies
/// everything, and the error names it.
Result<void> hold_exactly(const core::GateState& wanted, const GatedPorts& ports);
/// Makes the changes. After an error the gates hold a part of them.
Result<void> make_changes(const core::GateChanges& changes, const GatedPorts& ports);

}  // namespace mlcca
