// SPDX-License-Identifier: BSD-2-Clause
// Withdraw: everything of a described channel is refused until it is reinstated.
#include <fmt/core.h>

#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response withdraw(Context& context, const Asker& /*asker*/,
                  const control::WithdrawRequest& request) {
  const auto channel = channel_named(*context.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const core::EventChannel& withdrawn = context.scene.state->system().channels[*channel];
  if (withdrawn.unlisted)
    return invalid(fmt::format(
        "{0} is not described, only admitted: 'mlccactl release {0}' ends that", withdrawn.name));
  if (context.scene.state->withdrawn(*channel))
    return control::Done{withdrawn.name + " is withdrawn already"};
  if (const auto done = set_withdrawn(context, *channel, true); !done)
    return failed(done.error().text);
  const std::string line = fmt::format(
      "withdrawn: everything of {0} is refused until 'mlccactl reinstate {0}'", withdrawn.name);
  context.log.warning(Kind::revoked, line,
                      {.subject = withdrawn.subject, .channel = withdrawn.name});
  return control::Done{line};
}

}  // namespace mlcca::requests
