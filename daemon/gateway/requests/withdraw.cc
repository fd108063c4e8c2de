// SPDX-License-Identifier: BSD-2-Clause
// Withdraw: everything of a described channel is refused until it is reinstated.
#include <fmt/core.h>

#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/shared.hpp"

namespace mlcca::requests {

Response withdraw(const WithdrawParts& parts, const Asker& /*asker*/,
                  const control::WithdrawRequest& request) {
  const auto channel = channel_named(*parts.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const core::EventChannel& withdrawn = parts.scene.state->system().channels[*channel];
  if (withdrawn.unlisted)
    return invalid(fmt::format(
        "{0} is not described, only admitted: 'mlccactl release {0}' ends that", withdrawn.name));
  if (parts.scene.state->withdrawn(*channel))
    return control::Done{withdrawn.name + " is withdrawn already"};
  if (const auto done = set_withdrawn(parts, *channel, true); !done)
    return failed(done.error().text);
  const std::string line = fmt::format(
      "withdrawn: everything of {0} is refused until 'mlccactl reinstate {0}'", withdrawn.name);
  parts.log.warning(Kind::revoked, line, {.subject = withdrawn.subject, .channel = withdrawn.name});
  return control::Done{line};
}

}  // namespace mlcca::requests
