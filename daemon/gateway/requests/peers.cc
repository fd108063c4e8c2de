// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/peers.hpp"

#include <fmt/core.h>

namespace mlcca::requests {
namespace {

bool accepts(const core::Network& network) {
  return network.subscriptions.accept != core::Subscribing::nobody;
}

}  // namespace

std::string control_user_of(const core::Port& port) {
  if (port.control_uid == 0) return "root, since its Port states no control-user";
  return fmt::format("user {}, the control-user of its Port", port.control_uid);
}

std::vector<std::size_t> subscription_ports(const Scene& scene) {
  const core::System& system = scene.state->system();
  const auto& ports = system.gateways[scene.self].ports;
  std::vector<std::size_t> out;
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (accepts(system.networks[ports[p].network])) out.push_back(p);
  return out;
}

Result<std::size_t> subscription_port(const Scene& scene, uid_t user, const std::string& network) {
  const core::System& system = scene.state->system();
  const auto& ports = system.gateways[scene.self].ports;
  for (std::size_t p = 0; p < ports.size(); ++p) {
    const core::Network& at = system.networks[ports[p].network];
    if (at.name != network) continue;
    if (!accepts(at))
      return fail(
          fmt::format("{} accepts no subscriptions: its Subscriptions would have to", network));
    if (ports[p].control_uid != user)
      return fail(
          fmt::format("messages about subscriptions on {} are for programs of {}, and "
                      "this one is of user {}",
                      network, control_user_of(ports[p]), user));
    return p;
  }
  return fail(fmt::format("this gateway has no port on a network '{}'", network));
}

}  // namespace mlcca::requests
