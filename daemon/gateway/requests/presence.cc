// SPDX-License-Identifier: BSD-2-Clause
// Presence: the program that announces this gateway asks what to send, or has received the
// announcement of another gateway.
#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>

#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/peers.hpp"

namespace mlcca::requests {
namespace {

/// Why programs of this user do not announce this gateway; nullopt if they do, because they may
/// send the control traffic of a network that has Subscriptions.
std::optional<std::string> refuses_announcer(const PresenceParts& parts, uid_t user) {
  const auto& own = parts.scene.state->system().gateways[parts.scene.self].ports;
  const auto ports = subscription_ports(parts.scene);
  if (ports.empty()) return "no network of this gateway has Subscriptions: it is not announced";
  if (std::ranges::any_of(ports, [&](std::size_t p) { return own[p].control_uid == user; }))
    return std::nullopt;
  return fmt::format("this gateway is announced by programs of {}, and this one is of user {}",
                     control_user_of(own[ports.front()]), user);
}

}  // namespace

Response presence(const PresenceParts& parts, const Asker& asker,
                  const control::PresenceRequest& request) {
  if (request.gateway.empty()) {
    if (const auto why = refuses_announcer(parts, asker.peer.uid))
      return error_of(control::ErrorKind::forbidden, *why);
    return parts.presence.announce();
  }
  const auto port = subscription_port(parts.scene, asker.peer.uid, request.network);
  if (!port) return error_of(control::ErrorKind::forbidden, port.error().text);
  if (const auto taken = parts.presence.receive(request); !taken)
    return invalid(taken.error().text);
  return control::Done{"received"};
}

}  // namespace mlcca::requests
