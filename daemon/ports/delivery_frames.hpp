// SPDX-License-Identifier: BSD-2-Clause
// Sums up what the slots of a delivery have counted.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "core/gates/plan.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/ports/gated_ports.hpp"

namespace mlcca {

/// The counters of the slot of a rule; nullopt if there is none.
using CountersOf = std::function<std::optional<gates::SlotCounters>(const core::GateRule& rule)>;

/// Sums up the counters of `rules`. A frame that leaves is counted once: where it leaves; or, if
/// that entry is among those `shared` with other deliveries (sorted), where it came in.
[[nodiscard]] Frames delivery_frames(const core::GateState& rules,
                                     const std::vector<core::GateEntry>& shared,
                                     const CountersOf& counters_of);
/// The same with the counters of the gates of these ports.
[[nodiscard]] Frames delivery_frames(const core::GateState& rules,
                                     const std::vector<core::GateEntry>& shared,
                                     const GatedPorts& ports);

}  // namespace mlcca
