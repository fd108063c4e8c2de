// SPDX-License-Identifier: BSD-2-Clause
// Join: a drained gateway takes part in its cluster again.
#include <fmt/core.h>

#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/cluster_part.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response join(const DrainParts& parts, const Asker& /*asker*/,
              const control::JoinRequest& request) {
  if (auto bar = bars_part(parts.scene, parts.membership, request.gateway, "join"))
    return std::move(*bar);
  const auto& system = parts.scene.state->system();
  const std::string& self = system.gateways[parts.scene.self].name;
  if (!parts.membership->is_drained())
    return control::Done{self + " is not drained: nothing was changed"};
  if (const auto done = parts.membership->join(); !done) return failed(done.error().text);
  const std::string line =
      fmt::format("joins: {} takes part in the cluster {} again", self, system.name);
  parts.log.notice(Kind::gateway, line);
  return control::Done{line};
}

}  // namespace mlcca::requests
