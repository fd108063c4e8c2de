// SPDX-License-Identifier: BSD-2-Clause
// The gateway takes no part in its cluster any more, until it is to join again.
#include <fmt/core.h>

#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/cluster_part.hpp"

namespace mlcca::requests {

Response drain(Context& context, const Asker& /*asker*/, const control::DrainRequest& request) {
  if (auto bar = bars_part(context, request.gateway, "drain")) return std::move(*bar);
  const auto& system = context.scene.state->system();
  const std::string& self = system.gateways[context.scene.self].name;
  if (context.membership->is_drained()) return control::Done{self + " is drained already"};
  if (const auto done = context.membership->drain(); !done) return failed(done.error().text);
  const std::string line = fmt::format(
      "drained: networks that {} shares with others are closed, and what it has reserved is given "
      "back, until 'mlccactl cluster join'",
      self);
  context.log.warning(Kind::gateway, line);
  return control::Done{line};
}

}  // namespace mlcca::requests
