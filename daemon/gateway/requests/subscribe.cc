// SPDX-License-Identifier: BSD-2-Clause
// Subscribe: a peer on a network subscribes, renews its subscription, or ends it. A subscription is
// the admission of a subscriber there, with a key that belongs to the peer and the channel.
#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/attributes.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/keys.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/peers.hpp"
#include "daemon/gateway/requests/shared.hpp"
#include "daemon/gateway/turn.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kLongestSource = 45;  // the longest address in text

bool is_plain(const std::string& source) {
  return !source.empty() && source.size() <= kLongestSource &&
         std::ranges::all_of(source, [](char c) { return c > ' ' && c < 127; });
}

/// The admission that represents the subscription. The error: an attribute is not known.
Result<control::Admit> admission_of(const control::SubscribeRequest& request) {
  control::Admit out;
  out.channel = core::format_subject(request.subject);
  out.to = request.network;
  out.subscriber = fmt::format("peer-{}", request.source);
  out.key = subscription_keys(request.network) + fmt::format("{} {}", request.source, out.channel);
  out.lease_ns = request.lease_ns;
  const auto required = control::set_of(request.required);
  if (!required) return std::unexpected(required.error());
  out.required = control::attributes_of(*required);
  return out;
}

/// The refusal for a peer that has a granted subscription and now wants another one that would not
/// be granted beside it; the peer keeps what it has. Each attribute is compared by itself, so what
/// is granted of both separately would be granted together. nullopt if it is not refused.
std::optional<Response> refuses_other(const AdmitParts& parts, core::AdmissionId held,
                                      const control::Admit& wanted) {
  const core::State& state = *parts.scene.state;
  const auto asked = understand(state, wanted, parts.recorder.next_id());
  const auto known = state.admissions().find(held);
  if (!asked || !asked->admission || known == state.admissions().end()) return std::nullopt;
  const auto has = [&](const core::Verdict& v) { return parts.deliveries.concerns(v, held); };
  const auto& verdicts = state.decisions()[known->second].verdicts;
  if (!std::ranges::all_of(verdicts, [&](const core::Verdict& v) { return v.granted || !has(v); }))
    return std::nullopt;
  if (parts.membership != nullptr) static_cast<void>(parts.turn.settle());
  const core::Proposal proposal =
      as_it_could_be(*parts.scene.state, parts.membership, *asked->admission);
  if (proposal.fit()) return std::nullopt;
  Response response =
      outcome_of(parts.scene, parts.delivery_health, parts.membership, proposal, *asked, "admit");
  for (const core::Verdict* v : proposal.verdicts())
    if (!v->granted) parts.deliveries.verdict(Kind::refused, *v, verdict_line(state, *v));
  return response;
}

Response end(const AdmitParts& parts, const std::string& key) {
  const auto known = parts.admissions.with_key(key);
  if (!known) {
    const bool waited = parts.membership != nullptr &&
                        parts.membership->refuse(key, "it was ended while it waited");
    return control::Done{waited ? "the subscription does not wait any more"
                                : "there is no such subscription"};
  }
  if (const auto done = parts.admissions.release({*known}, "released"); !done)
    return failed(done.error().text);
  return control::Done{fmt::format("released admission {}", *known)};
}

}  // namespace

Response subscribe(const AdmitParts& parts, const Asker& asker,
                   const control::SubscribeRequest& request) {
  const auto port = subscription_port(parts.scene, asker.peer.uid, request.network);
  if (!port) return error_of(control::ErrorKind::forbidden, port.error().text);
  if (!is_plain(request.source))
    return invalid("say the source: a node or an address, such as 0x12 or 192.0.2.7");
  const core::System& system = parts.scene.state->system();
  const core::Network& network =
      system.networks[system.gateways[parts.scene.self].ports[*port].network];
  if (network.subscriptions.accept < core::Subscribing::with_attributes && !request.end)
    return error_of(control::ErrorKind::forbidden,
                    fmt::format("{} accepts no subscriptions (accept=\"gateways\")", network.name));
  if (!request.states_attributes && !request.end &&
      network.subscriptions.accept != core::Subscribing::all)
    return error_of(control::ErrorKind::forbidden,
                    fmt::format("{} accepts no subscriptions without attributes (accept=\"all\")",
                                network.name));
  const auto wanted = admission_of(request);
  if (!wanted) return invalid(wanted.error().text);
  if (request.end) return end(parts, wanted->key);
  const auto known = parts.admissions.with_key(wanted->key);
  const control::Request* held =
      known ? parts.recorder.contents().admissions.find(*known) : nullptr;
  if (held != nullptr && std::get<control::Admit>(held->body) != *wanted) {
    if (auto refused = refuses_other(parts, *known, *wanted)) return std::move(*refused);
    if (const auto done = parts.admissions.release({*known}, "replaced"); !done)
      return failed(done.error().text);
  }
  return admit(parts, asker, *wanted);
}

}  // namespace mlcca::requests
