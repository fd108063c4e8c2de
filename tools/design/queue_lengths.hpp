// SPDX-License-Identifier: BSD-2-Clause
// How long the queues of the gateways of a drafted description must be.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>

#include "core/model/system.hpp"

namespace mlcca::tools::design {

/// Makes the queues of the ports on each CAN bus as long as they must be if all that is described
/// is sent, and gives those lengths by number of the network: those alone that are longer than the
/// queue of a port is by default. Without a bound there is none. `system` has sorted bindings.
std::map<std::size_t, std::uint32_t> lengthen_queues(core::System& system);

}  // namespace mlcca::tools::design
