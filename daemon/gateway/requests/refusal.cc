// SPDX-License-Identifier: BSD-2-Clause
// Refusal: a subscription that this gateway has passed on was refused further on, or is granted
// after a refusal.
#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "base/text.hpp"
#include "core/admission/onward.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/peers.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kLongestReason = 512;

std::string printable_part(const std::string& text) { return printable(text, kLongestReason); }

}  // namespace

Response refusal(const RefusalParts& parts, const Asker& asker,
                 const control::RefusalRequest& request) {
  const auto port = subscription_port(parts.scene, asker.peer.uid, request.network);
  if (!port) return error_of(control::ErrorKind::forbidden, port.error().text);
  core::State& state = *parts.scene.state;
  const auto channel = channel_named(state, core::format_subject(request.subject));
  if (!channel) return invalid(channel.error().text);
  const auto onward = core::onward_of(state, parts.scene.self, *channel);
  const bool is_ours = std::ranges::any_of(onward, [&](const core::OnwardSubscription& one) {
    return state.system().networks[one.network].name == request.network;
  });
  if (!is_ours) return control::Done{"nothing of that is subscribed on the network now"};
  std::vector<std::uint64_t> concerned;
  for (const auto& [id, of] : state.admissions())
    if (of == *channel) concerned.push_back(id);
  const core::EventChannel& named = state.system().channels[*channel];
  const bool is_granted = request.reason.empty();
  parts.log.write({.kind = is_granted ? Kind::granted : Kind::refused,
                   .priority = is_granted ? 6 : 4,
                   .message = fmt::format("{} ({}) from {}: {} further on by {}{}", named.name,
                                          core::format_subject(named.subject), request.network,
                                          is_granted ? "granted again" : "refused",
                                          printable_part(request.source),
                                          is_granted ? "" : ": " + printable_part(request.reason)),
                   .subject = named.subject,
                   .channel = named.name,
                   .network = request.network,
                   .admissions = std::move(concerned)});
  return control::Done{"reported"};
}

}  // namespace mlcca::requests
