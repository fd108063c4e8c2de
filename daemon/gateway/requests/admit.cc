// SPDX-License-Identifier: BSD-2-Clause
// The request `admit`: adds a publisher or a subscriber to a channel at run time.
#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/gate_events.hpp"
#include "daemon/gateway/keys.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/requests/admitting.hpp"
#include "daemon/gateway/requests/elsewhere.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {
namespace {

/// Answers a request whose key was granted before with the present decision, and starts its lease
/// again. nullopt if the key is new.
std::optional<Response> admit_again(Context& context, const Asker& asker,
                                    const control::Admit& request) {
  const auto known = context.admissions.with_key(request.key);
  if (!known) return std::nullopt;
  const core::AdmissionId id = *known;
  const control::Request* granted = context.recorder.contents().admissions.find(id);
  if (granted == nullptr) return std::nullopt;
  if (std::get<control::Admit>(granted->body) != request)
    return invalid(
        fmt::format("admission {} has the key '{}' and was asked for otherwise: release it "
                    "first, or take another key",
                    id, request.key));
  const auto& left_out = context.admissions.left_out();
  if (const auto out = left_out.find(id); out != left_out.end()) {
    if (!context.admissions.waits(id))
      return invalid(words_of(out->second) + ": release it, or correct the description");
    Response response = failed(words_of(out->second));
    if (context.admissions.own(id, request, asker.peer.session)) response.owned = id;
    return response;
  }
  Response response = context.channels.of_admission(id);
  if (context.admissions.own(id, request, asker.peer.session)) response.owned = id;
  response.held = context.recorder.is_uncommitted(id);
  return response;
}

/// Writes the admission to the journal and the gates, or to neither. After an error nothing has
/// changed.
Result<void> put_in_force(Context& context, core::Proposal proposal,
                          const control::Request& request, const Asker& asker,
                          const std::string& through) {
  auto done = context.recorder.admit(request, asker.peer.uid, through);
  if (done) done = context.gates.apply(proposal.changes(context.scene.self));
  if (done) std::move(proposal).accept();
  return done;
}

Response admit_new(Context& context, const Asker& asker, const control::Admit& request,
                   const ParsedRequest& asked) {
  if (const auto why = bars(context, asker, request, asked)) return *why;
  core::State& state = *context.scene.state;
  if (context.membership != nullptr) static_cast<void>(context.turn.settle());
  if (gateway_to_ask(context, request, asked)) return ask_other_gateway(context, asker, request);
  std::optional<core::Proposal> proposal(state.propose(*asked.admission));
  if (context.membership == nullptr || (proposal->fit() && !crosses_others(context, *proposal)))
    return decided(context, asker, request, asked, std::move(*proposal));
  proposal.reset();
  proposal.emplace(state.wish(*asked.admission));
  if (!proposal->fit()) return decided(context, asker, request, asked, std::move(*proposal));
  proposal.reset();
  return ask_store(context, asker, request);
}

Response admit_listed(Context& context, const Asker& asker, const control::Admit& request) {
  const auto asked = understand(*context.scene.state, request, context.recorder.next_id());
  if (!asked) return invalid(asked.error().text);
  if (asked->admission) return admit_new(context, asker, request, *asked);
  if (!request.key.empty() || request.lease_ns != 0 || request.hold)
    return invalid(
        "these ends are described: a key, a lease or hold needs a new publisher or "
        "subscriber (say its attributes, or give it a name)");
  return known(context, asker, *asked);
}

/// Why the network accepts no further subscription; nullopt if it does, or if this is no
/// subscription.
std::optional<std::string> exceeds_policy(const Context& context, const control::Admit& request) {
  const std::string keys = subscription_keys(request.to);
  if (!request.key.starts_with(keys)) return std::nullopt;
  const auto& networks = context.scene.state->system().networks;
  const auto network = std::ranges::find(networks, request.to, &core::Network::name);
  const std::size_t now = context.admissions.count_of_keys(keys);
  if (network == networks.end() || now < network->subscriptions.most) return std::nullopt;
  return fmt::format("{} has {} subscriptions, and its Subscriptions allow no more", network->name,
                     now);
}

}  // namespace

std::optional<Response> bars(const Context& context, const Asker& asker,
                             const control::Admit& request, const ParsedRequest& asked) {
  if (const auto why =
          Quotas::refuse_admission(asker.peer.uid, context.recorder.contents().admissions))
    return failed("nothing was changed: " + *why);
  if (const auto lack = lacks_pairs(context, asked)) return invalid(*lack);
  if (const auto why = exceeds_policy(context, request)) return invalid(*why);
  return std::nullopt;
}

bool crosses_others(const Context& context, const core::Proposal& proposal) {
  return std::ranges::any_of(proposal.verdicts(), [&](const core::Verdict* v) {
    return std::ranges::any_of(v->route, [&](const core::Place& place) {
      return place.kind == core::Place::Kind::gateway && place.index != context.scene.self;
    });
  });
}

Response decided(Context& context, const Asker& asker, const control::Admit& request,
                 const ParsedRequest& asked, core::Proposal proposal, const std::string& through) {
  if (const auto lack = proposal.exceeds_capacity(context.scene.self)) return invalid(*lack);
  const core::State& state = *context.scene.state;
  const core::AdmissionId id = asked.admission->id;
  Response response = outcome_of(context, proposal, asked, "admit");
  if (!proposal.fit()) {
    for (const core::Verdict* v : proposal.verdicts())
      if (!v->granted) context.deliveries.verdict(Kind::refused, *v, verdict_line(state, *v));
    return response;
  }
  const auto done = put_in_force(context, std::move(proposal), {id, request}, asker, through);
  if (!done) {
    context.recorder.take_back(id);
    static_cast<void>(context.turn.enforce());
    return failed("nothing was changed: " + done.error().text);
  }
  context.turn.set_bands();
  response.held = true;
  context.admissions.add(id, request, asker.peer.session);
  if (request.hold) response.owned = id;
  context.recorder.note(asked.channel);
  context.forwarding.want(asked.channel);
  for (const core::Verdict& v : state.decisions()[asked.channel].verdicts)
    if (context.deliveries.concerns(v, id)) {
      context.deliveries.verdict(Kind::granted, v, verdict_line(state, v));
      context.gate_events.repeat_missing(v);
    }
  return response;
}

Response admit(Context& context, const Asker& asker, const control::Admit& request) {
  if (const auto key = check_key(request.key); !key) return invalid(key.error().text);
  if (auto again = admit_again(context, asker, request)) return std::move(*again);
  if (context.membership != nullptr && context.membership->waits_for(request.key))
    return failed(
        fmt::format("nothing was changed: an admission with the key '{}' waits for the store: ask "
                    "again in a few seconds",
                    request.key));
  if (const auto listed = list(*context.scene.state, request); !listed)
    return invalid(listed.error().text);
  if (!request.unlisted) return admit_listed(context, asker, request);
  context.tags.claim();
  Response response = admit_listed(context, asker, request);
  context.tags.leave_unused();
  return response;
}

}  // namespace mlcca::requests
