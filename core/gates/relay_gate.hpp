// SPDX-License-Identifier: BSD-2-Clause
// Gates below a mesh: one on a radio drops what its node relays for others, which is not admitted
// there. One on the mesh's own device sees what the node itself sends and gets.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::core {

enum class RelayGate : std::uint8_t {
  none,    ///< there is no gate, or as far as the description says it does not see what is relayed
  radio,   ///< it is below the mesh's own device
  routed,  ///< the node relays by routing, and has no device for that
};

/// The gate of a gateway's port on a network.
[[nodiscard]] RelayGate relay_gate(const System& system, std::size_t network, std::size_t gateway);

/// What `check` and status say of a gate that drops what its node relays; empty: none does. In a
/// mesh of two nodes nobody relays.
[[nodiscard]] std::string relay_problem(const System& system, std::size_t network,
                                        std::size_t gateway);
/// What to do about it.
[[nodiscard]] std::string relay_hint(const System& system, std::size_t network,
                                     std::size_t gateway);

}  // namespace mlcca::core
