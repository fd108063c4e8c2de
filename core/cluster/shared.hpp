// SPDX-License-Identifier: BSD-2-Clause
// Compares which networks gateways share in one description and the next.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core::cluster {

/// A port of a gateway on a network that other gateways have ports on as well.
struct SharedPort {
  std::string network;
  decltype(Port::identity) identity;
};
/// The shared ports of gateway `self`.
[[nodiscard]] std::vector<SharedPort> shared_ports(const System& system, std::size_t self);

/// Why a gateway may not change from one description to another; empty if it may. It must not use a
/// network alone that others are on by `before` but not by `after`: it would use it at once, while
/// a gateway that does not know `after` yet still sends there.
[[nodiscard]] std::string no_longer_shared(std::span<const SharedPort> before, const System& after,
                                           std::size_t self_after);
[[nodiscard]] inline std::string no_longer_shared(const System& before, std::size_t self_before,
                                                  const System& after, std::size_t self_after) {
  return no_longer_shared(shared_ports(before, self_before), after, self_after);
}

}  // namespace mlcca::core::cluster
