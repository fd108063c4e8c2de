// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/presence.hpp"

#include "mlcca/arithmetic.hpp"

namespace mlcca::core {

std::vector<std::size_t> presence_networks(const System& system, std::size_t gateway,
                                           std::size_t other) {
  std::vector<std::size_t> out;
  const Gateway& one = system.gateways[gateway];
  const Gateway& two = system.gateways[other];
  if (one.presence == 0 || two.presence == 0) return out;
  for (const Port& port : one.ports)
    if (two.port_on(port.network) != nullptr &&
        system.networks[port.network].subscriptions.accept != Subscribing::nobody)
      out.push_back(port.network);
  return out;
}

Value presence_lasts(Value interval, Value grace) {
  return add_saturating(mul_saturating(interval, kPresenceLosses),
                        grace < kLongestPresenceGrace ? grace : kLongestPresenceGrace);
}

}  // namespace mlcca::core
