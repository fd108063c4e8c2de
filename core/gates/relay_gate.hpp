// SPDX-License-Identifier: BSD-2-Clause
// Detects gates below a mesh. A gate on the radio drops what its node relays for others, because
// that is not admitted there. A gate on the mesh's own device only sees what the node itself sends
// and receives.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Whether the gate of a port on a mesh sees relayed frames.
enum class RelayGate : std::uint8_t {
  none,    ///< there is no gate, or as far as the description shows it does not see relayed frames
  radio,   ///< it is on the radio below the mesh's own device
  routed,  ///< the node relays by IP routing, so there is no separate device of the mesh
};

/// The kind of gate of a gateway's port on a network.
[[nodiscard]] RelayGate relay_gate(const System& system, std::size_t network, std::size_t gateway);

/// The finding about a gate that drops what its node relays, for `check` and status; empty if there
/// is none. In a mesh of two nodes nobody relays.
[[nodiscard]] std::string relay_problem(const System& system, std::size_t network,
                                        std::size_t gateway);
/// How to correct the description; belongs to relay_problem().
[[nodiscard]] std::string relay_hint(const System& system, std::size_t network,
                                     std::size_t gateway);

}  // namespace mlcca::core
