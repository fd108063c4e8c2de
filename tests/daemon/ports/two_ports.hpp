// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <string>

#include "core/model/system.hpp"

namespace mlcca::test {

/// A gateway with the ports eth0 and eth1 on networks lan0 and lan1, whose gates must be others
/// where one of these is.
inline core::System two_ports(std::size_t channels, core::Refused refused = core::Refused::error) {
  core::System system;
  system.networks.resize(2);
  system.gateways.resize(1);
  system.gateways[0].ports.resize(2);
  for (std::size_t n = 0; n < 2; ++n) {
    system.networks[n].name = "lan" + std::to_string(n);
    system.networks[n].kind = core::NetworkKind::udp_multicast;
    system.networks[n].profile = core::Profile::famouso;
    system.gateways[0].ports[n].network = n;
    system.gateways[0].ports[n].identity.name = "eth" + std::to_string(n);
    system.gateways[0].ports[n].refused = refused;
  }
  system.channels.resize(channels);
  return system;
}

}  // namespace mlcca::test
