// SPDX-License-Identifier: BSD-2-Clause
// Reinstate: a withdrawn channel is decided again.
#include <fmt/core.h>

#include <algorithm>

#include "base/many.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/shared.hpp"

namespace mlcca::requests {

Response reinstate(const WithdrawParts& parts, const Asker& /*asker*/,
                   const control::ReinstateRequest& request) {
  const auto channel = channel_named(*parts.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const core::EventChannel& reinstated = parts.scene.state->system().channels[*channel];
  if (!parts.scene.state->withdrawn(*channel))
    return control::Done{reinstated.name + " is not withdrawn: nothing was changed"};
  if (const auto done = set_withdrawn(parts, *channel, false); !done)
    return failed(done.error().text);
  const auto& verdicts = parts.scene.state->decisions()[*channel].verdicts;
  const auto granted = std::ranges::count_if(verdicts, &core::Verdict::granted);
  const std::string line = fmt::format("reinstated: {} of {} of {} {} granted", granted,
                                       many(verdicts.size(), "delivery", "deliveries"),
                                       reinstated.name, granted == 1 ? "is" : "are");
  parts.log.notice(Kind::reinstated, line,
                   {.subject = reinstated.subject, .channel = reinstated.name});
  return control::Done{line};
}

}  // namespace mlcca::requests
