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
#include "daemon/gateway/requests/peers.hpp"
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
std::optional<Response> refuses_other(Context& context, core::AdmissionId held,
                                      const control::Admit& wanted) {
  const core::State& state = *context.scene.state;
  const auto asked = understand(state, wanted, context.recorder.next_id());
  const auto known = state.admissions().find(held);
  if (!asked || !asked->admission || known == state.admissions().end()) return std::nullopt;
  const auto has = [&](const core::Verdict& v) { return context.deliveries.concerns(v, held); };
  const auto& verdicts = state.decisions()[known->second].verdicts;
  if (!std::ranges::all_of(verdicts, [&](const core::Verdict& v) { return v.granted || !has(v); }))
    return std::nullopt;
  if (context.membership != nullptr) static_cast<void>(context.turn.settle());
  const core::Proposal proposal = as_it_could_be(context, *asked->admission);
  if (proposal.fit()) return std::nullopt;
  Response response = outcome_of(context, proposal, *asked, "admit");
  for (const core::Verdict* v : proposal.verdicts())
    if (!v->granted) context.deliveries.verdict(Kind::refused, *v, verdict_line(state, *v));
  return response;
}

Response end(Context& context, const std::string& key) {
  const auto known = context.admissions.with_key(key);
  if (!known) {
    const bool waited = context.membership != nullptr &&
                        context.membership->refuse(key, "it was ended while it waited");
    return control::Done{waited ? "the subscription does not wait any more"
                                : "there is no such subscription"};
  }
  if (const auto done = context.admissions.release({*known}, "released"); !done)
    return failed(done.error().text);
  return control::Done{fmt::format("released admission {}", *known)};
}

}  // namespace

Response subscribe(Context& context, const Asker& asker, const control::SubscribeRequest& request) {
  const auto port = subscription_port(context, asker.peer.uid, request.network);
  if (!port) return error_of(control::ErrorKind::forbidden, port.error().text);
  if (!is_plain(request.source))
    return invalid("say the source: a node or an address, such as 0x12 or 192.0.2.7");
  const core::System& system = context.scene.state->system();
  const core::Network& network =
      system.networks[system.gateways[context.scene.self].ports[*port].network];
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
  if (request.end) return end(context, wanted->key);
  const auto known = context.admissions.with_key(wanted->key);
  const control::Request* held =
      known ? context.recorder.contents().admissions.find(*known) : nullptr;
  if (held != nullptr && std::get<control::Admit>(held->body) != *wanted) {
    if (auto refused = refuses_other(context, *known, *wanted)) return std::move(*refused);
    if (const auto done = context.admissions.release({*known}, "replaced"); !done)
      return failed(done.error().text);
  }
  return admit(context, asker, *wanted);
}

}  // namespace mlcca::requests
