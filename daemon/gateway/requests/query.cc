// SPDX-License-Identifier: BSD-2-Clause
// The request `query`: what would be decided. Changes nothing.
#include <variant>

#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/shared.hpp"
#include "daemon/gateway/turn.hpp"

namespace mlcca::requests {
namespace {

Body would_be(const QueryParts& parts, const control::Query& request, const ParsedRequest& asked) {
  if (const auto why =
          decided_elsewhere(parts.scene, parts.recorder, parts.membership, request, asked))
    return invalid(*why);
  if (const auto lack = lacks_pairs(*parts.scene.state, asked)) return invalid(*lack);
  const core::Proposal proposal =
      as_it_could_be(*parts.scene.state, parts.membership, *asked.admission);
  if (const auto lack = proposal.exceeds_capacity(parts.scene.self)) return invalid(*lack);
  Body body =
      outcome_of(parts.scene, parts.delivery_health, parts.membership, proposal, asked, "decide");
  // Nothing is admitted, so there is no id that could be released.
  if (auto* const would_be = std::get_if<control::Channels>(&body))
    for (control::Channel& channel : would_be->channels)
      if (channel.admission == asked.admission->id) channel.admission = 0;
  return body;
}

}  // namespace

Response query(const QueryParts& parts, const Asker& asker, const control::Query& request) {
  core::State& state = *parts.scene.state;
  if (const auto listed = list(state, request); !listed) return invalid(listed.error().text);
  const auto asked = understand(state, request, parts.recorder.next_id());
  if (!asked) return invalid(asked.error().text);
  if (parts.membership != nullptr) static_cast<void>(parts.turn.settle());
  if (!asked->admission)
    return known(parts.channels, parts.estimates, parts.replies, asker, *asked);
  if (!parts.estimates.has_many_ends(asked->channel)) return would_be(parts, request, *asked);
  return parts.replies.aside(
      asker, [parts, request, asked = *asked] { return would_be(parts, request, asked); });
}

}  // namespace mlcca::requests
