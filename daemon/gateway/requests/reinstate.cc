// SPDX-License-Identifier: BSD-2-Clause
// Reinstate: a withdrawn channel is decided again.
#include <fmt/core.h>

#include <algorithm>

#include "base/many.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response reinstate(Context& context, const Asker& /*asker*/,
                   const control::ReinstateRequest& request) {
  const auto channel = channel_named(*context.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const core::EventChannel& reinstated = context.scene.state->system().channels[*channel];
  if (!context.scene.state->withdrawn(*channel))
    return control::Done{reinstated.name + " is not withdrawn: nothing was changed"};
  if (const auto done = set_withdrawn(context, *channel, false); !done)
    return failed(done.error().text);
  const auto& verdicts = context.scene.state->decisions()[*channel].verdicts;
  const auto granted = std::ranges::count_if(verdicts, &core::Verdict::granted);
  const std::string line = fmt::format("reinstated: {} of {} of {} {} granted", granted,
                                       many(verdicts.size(), "delivery", "deliveries"),
                                       reinstated.name, granted == 1 ? "is" : "are");
  context.log.notice(Kind::reinstated, line,
                     {.subject = reinstated.subject, .channel = reinstated.name});
  return control::Done{line};
}

}  // namespace mlcca::requests
