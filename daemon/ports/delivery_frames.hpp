// SPDX-License-Identifier: BSD-2-Clause
// What came and left by the slots of a delivery.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "core/gates/plan.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// What the slot of a rule has counted; nothing where there is none.
using CountersOf = std::function<std::optional<enforce::SlotCounters>(const core::GateRule& rule)>;

/// A frame that leaves has passed once: it is counted where it leaves, or, where that entry is one
/// of those `shared` with others (sorted), where it came in.
[[nodiscard]] Frames delivery_frames(const core::GateState& rules,
                                     const std::vector<core::GateEntry>& shared,
                                     const CountersOf& counters_of);
/// By the gates of these ports.
[[nodiscard]] Frames delivery_frames(const core::GateState& rules,
                                     const std::vector<core::GateEntry>& shared,
                                     const GatedPorts& ports);

}  // namespace mlcca
