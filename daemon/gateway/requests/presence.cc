// SPDX-License-Identifier: BSD-2-Clause
// The program that announces this gateway asks what to send, or has received another one's message.
#include <algorithm>

#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/peers.hpp"

namespace mlcca::requests {
namespace {

/// May send the control traffic of a network that has Subscriptions.
bool is_announcer(const Context& context, uid_t user) {
  const auto& own = context.scene.state->system().gateways[context.scene.self].ports;
  return std::ranges::any_of(subscription_ports(context),
                             [&](std::size_t p) { return own[p].control_uid == user; });
}

}  // namespace

Response presence(Context& context, const Asker& asker, const control::PresenceRequest& request) {
  if (request.gateway.empty()) {
    if (!is_announcer(context, asker.peer.uid))
      return error_of(control::ErrorKind::forbidden,
                      "this gateway is announced by the control-user of its ports on networks with "
                      "Subscriptions");
    return context.presence.announce();
  }
  const auto port = subscription_port(context, asker.peer.uid, request.network);
  if (!port) return error_of(control::ErrorKind::forbidden, port.error().text);
  if (const auto taken = context.presence.receive(request); !taken)
    return invalid(taken.error().text);
  return control::Done{"received"};
}

}  // namespace mlcca::requests
