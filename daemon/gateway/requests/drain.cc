// SPDX-License-Identifier: BSD-2-Clause
// Drain: the gateway leaves its cluster until it is to join again.
#include <fmt/core.h>

#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/cluster_part.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response drain(const DrainParts& parts, const Asker& /*asker*/,
               const control::DrainRequest& request) {
  if (auto bar = bars_part(parts.scene, parts.membership, request.gateway, "drain"))
    return std::move(*bar);
  const auto& system = parts.scene.state->system();
  const std::string& self = system.gateways[parts.scene.self].name;
  Membership& membership = *parts.membership;
  // A drain until join already covers one until a restart.
  if (membership.is_drained() && (request.until_restart || !membership.is_drained_until_restart()))
    return control::Done{self + " is drained already"};
  if (const auto done = membership.drain(request.until_restart); !done)
    return failed(done.error().text);
  const std::string line = fmt::format(
      "drained: networks that {} shares with others are closed, and what it has reserved is given "
      "back, until {}",
      self, request.until_restart ? "mlccad is started again" : "'mlccactl cluster join'");
  parts.log.warning(Kind::gateway, line);
  return control::Done{line};
}

}  // namespace mlcca::requests
