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
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/shared.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {
namespace {

/// Answers a request whose key was granted before with the present decision, and starts its lease
/// again. nullopt if the key is new.
std::optional<Response> admit_again(const AdmitParts& parts, const Asker& asker,
                                    const control::Admit& request) {
  const auto known = parts.admissions.with_key(request.key);
  if (!known) return std::nullopt;
  const core::AdmissionId id = *known;
  const control::Request* granted = parts.recorder.contents().admissions.find(id);
  if (granted == nullptr) return std::nullopt;
  if (std::get<control::Admit>(granted->body) != request)
    return invalid(
        fmt::format("admission {} has the key '{}' and was asked for otherwise: release it "
                    "first, or take another key",
                    id, request.key));
  const auto& left_out = parts.admissions.left_out();
  if (const auto out = left_out.find(id); out != left_out.end()) {
    if (!parts.admissions.waits(id))
      return invalid(words_of(out->second) + ": release it, or correct the description");
    Response response = failed(words_of(out->second));
    if (parts.admissions.own(id, request, asker.peer.session)) response.owned = id;
    return response;
  }
  Response response = parts.channels.of_admission(id);
  if (parts.admissions.own(id, request, asker.peer.session)) response.owned = id;
  response.held = parts.recorder.is_uncommitted(id);
  return response;
}

/// Writes the admission to the journal and the gates, or to neither. After an error nothing has
/// changed.
Result<void> put_in_force(const AdmitParts& parts, core::Proposal proposal,
                          const control::Request& request, const Asker& asker,
                          const std::string& through) {
  auto done = parts.recorder.admit(request, asker.peer.uid, through);
  if (done) done = parts.gates.apply(proposal.changes(parts.scene.self));
  if (done) std::move(proposal).accept();
  return done;
}

Response admit_new(const AdmitParts& parts, const Asker& asker, const control::Admit& request,
                   const ParsedRequest& asked) {
  if (const auto why = bars(parts, asker, request, asked)) return *why;
  core::State& state = *parts.scene.state;
  if (parts.membership != nullptr) static_cast<void>(parts.turn.settle());
  if (gateway_to_ask(parts.scene, parts.recorder, parts.membership, request, asked))
    return ask_other_gateway(parts, asker, request);
  std::optional<core::Proposal> proposal(state.propose(*asked.admission));
  if (parts.membership == nullptr || (proposal->fit() && !crosses_others(parts.scene, *proposal)))
    return decided(parts, asker, request, asked, std::move(*proposal));
  proposal.reset();
  proposal.emplace(state.wish(*asked.admission));
  if (!proposal->fit()) return decided(parts, asker, request, asked, std::move(*proposal));
  proposal.reset();
  return ask_store(parts, asker, request);
}

Response admit_listed(const AdmitParts& parts, const Asker& asker, const control::Admit& request) {
  const auto asked = understand(*parts.scene.state, request, parts.recorder.next_id());
  if (!asked) return invalid(asked.error().text);
  if (asked->admission) return admit_new(parts, asker, request, *asked);
  if (!request.key.empty() || request.lease_ns != 0 || request.hold)
    return invalid(
        "these ends are described: a key, a lease or hold needs a new publisher or "
        "subscriber (say its attributes, or give it a name)");
  return known(parts.channels, parts.estimates, parts.replies, asker, *asked);
}

/// Why the network accepts no further subscription; nullopt if it does, or if this is no
/// subscription.
std::optional<std::string> exceeds_policy(const AdmitParts& parts, const control::Admit& request) {
  const std::string keys = subscription_keys(request.to);
  if (!request.key.starts_with(keys)) return std::nullopt;
  const auto& networks = parts.scene.state->system().networks;
  const auto network = std::ranges::find(networks, request.to, &core::Network::name);
  const std::size_t now = parts.admissions.count_of_keys(keys);
  if (network == networks.end() || now < network->subscriptions.most) return std::nullopt;
  return fmt::format("{} has {} subscriptions, and its Subscriptions allow no more", network->name,
                     now);
}

}  // namespace

std::optional<Response> bars(const AdmitParts& parts, const Asker& asker,
                             const control::Admit& request, const ParsedRequest& asked) {
  if (const auto why =
          Quotas::refuse_admission(asker.peer.uid, parts.recorder.contents().admissions))
    return failed("nothing was changed: " + *why);
  if (const auto lack = lacks_pairs(*parts.scene.state, asked)) return invalid(*lack);
  if (const auto why = exceeds_policy(parts, request)) return invalid(*why);
  return std::nullopt;
}

bool crosses_others(const Scene& scene, const core::Proposal& proposal) {
  return std::ranges::any_of(proposal.verdicts(), [&](const core::Verdict* v) {
    return std::ranges::any_of(v->route, [&](const core::Place& place) {
      return place.kind == core::Place::Kind::gateway && place.index != scene.self;
    });
  });
}

Response decided(const AdmitParts& parts, const Asker& asker, const control::Admit& request,
                 const ParsedRequest& asked, core::Proposal proposal, const std::string& through) {
  if (const auto lack = proposal.exceeds_capacity(parts.scene.self)) return invalid(*lack);
  const core::State& state = *parts.scene.state;
  const core::AdmissionId id = asked.admission->id;
  Response response =
      outcome_of(parts.scene, parts.delivery_health, parts.membership, proposal, asked, "admit");
  if (!proposal.fit()) {
    for (const core::Verdict* v : proposal.verdicts())
      if (!v->granted) parts.deliveries.verdict(Kind::refused, *v, verdict_line(state, *v));
    return response;
  }
  const auto done = put_in_force(parts, std::move(proposal), {id, request}, asker, through);
  if (!done) {
    parts.recorder.take_back(id);
    static_cast<void>(parts.turn.enforce());
    return failed("nothing was changed: " + done.error().text);
  }
  parts.turn.set_bands();
  response.held = true;
  parts.admissions.add(id, request, asker.peer.session);
  if (request.hold) response.owned = id;
  parts.recorder.note(asked.channel);
  parts.forwarding.want(asked.channel);
  for (const core::Verdict& v : state.decisions()[asked.channel].verdicts)
    if (parts.deliveries.concerns(v, id)) {
      parts.deliveries.verdict(Kind::granted, v, verdict_line(state, v));
      parts.gate_events.repeat_missing(v);
    }
  return response;
}

Response admit(const AdmitParts& parts, const Asker& asker, const control::Admit& request) {
  if (const auto key = check_key(request.key); !key) return invalid(key.error().text);
  if (auto again = admit_again(parts, asker, request)) return std::move(*again);
  if (parts.membership != nullptr && parts.membership->waits_for(request.key))
    return failed(
        fmt::format("nothing was changed: an admission with the key '{}' waits for the store: ask "
                    "again in a few seconds",
                    request.key));
  if (const auto listed = list(*parts.scene.state, request); !listed)
    return invalid(listed.error().text);
  if (!request.unlisted) return admit_listed(parts, asker, request);
  parts.tags.claim();
  Response response = admit_listed(parts, asker, request);
  parts.tags.leave_unused();
  return response;
}

}  // namespace mlcca::requests
