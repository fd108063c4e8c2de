// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/can_layer.hpp"
#include "relay/layers/layer.hpp"
#include "relay/layers/udp_layer.hpp"
#include "relay/layers/wpan_layer.hpp"

namespace mlcca::relay {

Result<std::unique_ptr<Layer>> open_layer(const control::Endpoint& endpoint) {
  if (endpoint.can) return CanLayer::open(endpoint);
  return endpoint.wpan ? WpanLayer::open(endpoint) : UdpLayer::open(endpoint);
}

}  // namespace mlcca::relay
