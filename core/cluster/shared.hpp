// SPDX-License-Identifier: BSD-2-Clause
// Which networks gateways share, from one description to the next.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core::cluster {

/// A port of a gateway on a network that others are on, too.
struct SharedPort {
  std::string network;
  decltype(Port::identity) identity;
};
[[nodiscard]] std::vector<SharedPort> shared_ports(const System& system, std::size_t self);

/// A gateway holds back on the networks that its description shares with others. One that others
/// were on by `before`, and are not any more by `after`, it would use at once, while a gateway that
/// does not know `after` yet still sends there. Why it may not; empty: there is no such network.
[[nodiscard]] std::string no_longer_shared(std::span<const SharedPort> before, const System& after,
                                           std::size_t self_after);
[[nodiscard]] inline std::string no_longer_shared(const System& before, std::size_t self_before,
                                                  const System& after, std::size_t self_after) {
  return no_longer_shared(shared_ports(before, self_before), after, self_after);
}

}  // namespace mlcca::core::cluster
