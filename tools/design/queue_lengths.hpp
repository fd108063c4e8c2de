// SPDX-License-Identifier: BSD-2-Clause
// The queue lengths that a drafted description needs at the ports of its gateways.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>

#include "core/design/inspect.hpp"
#include "core/model/system.hpp"

namespace mlcca::tools::design {

/// Lengthens the queues of the ports on each CAN bus as far as needed if everything that is
/// described is sent. Returns the lengths that exceed the default, by index of the network; none
/// for a bus without a bound. `system` must have sorted bindings.
std::map<std::size_t, std::uint32_t> lengthen_queues(core::System& system);
/// Whether it would lengthen one; `buses`: what a check found out of them.
[[nodiscard]] bool needs_longer_queues(const core::System& system,
                                       const core::InspectedBuses& buses);

}  // namespace mlcca::tools::design
