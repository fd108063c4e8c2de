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

/// Clears the members that do not matter. They are listed explicitly, so that a new member of
/// Endpoint matters until it is added here.
control::Endpoint form_of_layer(control::Endpoint endpoint) {
  const control::Endpoint none;
  endpoint.network = none.network;
  endpoint.id = none.id;
  endpoint.mask = none.mask;
  endpoint.classic = none.classic;
  endpoint.fd = none.fd;
  endpoint.frame_bytes = none.frame_bytes;
  endpoint.fragmented = none.fragmented;
  endpoint.address = none.address;
  endpoint.publisher = none.publisher;
  endpoint.period_ns = none.period_ns;
  endpoint.silence_ns = none.silence_ns;
  endpoint.event_cost_ns = none.event_cost_ns;
  endpoint.byte_cost = none.byte_cost;
  endpoint.tolerance_ns = none.tolerance_ns;
  return endpoint;
}

}  // namespace mlcca::relay
