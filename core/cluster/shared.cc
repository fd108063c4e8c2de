// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/shared.hpp"

namespace mlcca::core::cluster {

std::vector<SharedPort> shared_ports(const System& system, std::size_t self) {
  const std::vector<bool> shared = shared_networks(system);
  std::vector<SharedPort> ports;
  for (const Port& port : system.gateways[self].ports)
    if (shared[port.network])
      ports.push_back({.network = system.networks[port.network].name, .identity = port.identity});
  return ports;
}

std::string no_longer_shared(std::span<const SharedPort> before, const System& after,
                             std::size_t self_after) {
  const std::vector<bool> shared = shared_networks(after);
  for (const SharedPort& was : before)
    for (const Port& is : after.gateways[self_after].ports) {
      const bool same =
          is.identity == was.identity || after.networks[is.network].name == was.network;
      if (same && !shared[is.network])
        return "others are on " + was.network +
               " by the description in force, and would not be any more: "
               "roll out one without that network first, and then this one";
    }
  return {};
}

}  // namespace mlcca::core::cluster
