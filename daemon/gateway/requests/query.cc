// SPDX-License-Identifier: BSD-2-Clause
// The request `query`: what would be decided. Changes nothing.
#include <variant>

#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/turn.hpp"

namespace mlcca::requests {
namespace {

Body would_be(Context& context, const control::Query& request, const ParsedRequest& asked) {
  if (const auto why = decided_elsewhere(context, request, asked)) return invalid(*why);
  if (const auto lack = lacks_pairs(context, asked)) return invalid(*lack);
  const core::Proposal proposal = as_it_could_be(context, *asked.admission);
  if (const auto lack = proposal.exceeds_capacity(context.scene.self)) return invalid(*lack);
  Body body = outcome_of(context, proposal, asked, "decide");
  // Nothing is admitted, so there is no id that could be released.
  if (auto* const would_be = std::get_if<control::Channels>(&body))
    for (control::Channel& channel : would_be->channels)
      if (channel.admission == asked.admission->id) channel.admission = 0;
  return body;
}

}  // namespace

Response query(Context& context, const Asker& asker, const control::Query& request) {
  core::State& state = *context.scene.state;
  if (const auto listed = list(state, request); !listed) return invalid(listed.error().text);
  const auto asked = understand(state, request, context.recorder.next_id());
  if (!asked) return invalid(asked.error().text);
  if (context.membership != nullptr) static_cast<void>(context.turn.settle());
  if (!asked->admission) return known(context, asker, *asked);
  if (!context.channels.has_many_ends(asked->channel)) return would_be(context, request, *asked);
  return made_aside(context, asker, [&context, request, asked = *asked] {
    return would_be(context, request, asked);
  });
}

}  // namespace mlcca::requests
