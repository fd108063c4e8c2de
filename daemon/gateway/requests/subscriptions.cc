// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions: where peers may subscribe, and what this gateway subscribes elsewhere for
// endpoints behind it.
#include <algorithm>
#include <cstddef>
#include <utility>

#include "control/attributes.hpp"
#include "core/admission/onward.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/peers.hpp"
#include "daemon/gateway/slice_budget.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kOnwardRow = 256;  // typical bytes on the wire

/// Whether the subscription is also for an endpoint that is described, or admitted otherwise than
/// by a subscription over a network.
bool begins_here(const SubscriptionsParts& parts, const core::OnwardSubscription& one) {
  return one.described || std::ranges::any_of(one.admitted, [&](core::AdmissionId id) {
           return !parts.admissions.came_over_a_network(id);
         });
}

void add_channel(const SubscriptionsParts& parts, std::size_t channel, control::Subscriptions& to) {
  core::State& state = *parts.scene.state;
  const core::System& system = state.system();
  const core::EventChannel& described = system.channels[channel];
  for (const core::OnwardSubscription& one : core::onward_of(state, parts.scene.self, channel))
    to.onward.push_back({.subject = described.subject,
                         .channel = described.name,
                         .network = system.networks[one.network].name,
                         .required = control::attributes_of(one.required),
                         .problem = one.problem,
                         .begins_here = begins_here(parts, one)});
}

/// The next channels from `at` on, as many as one turn has time for.
serve::Slice some_onward(const SubscriptionsParts& parts, std::size_t& at) {
  control::Subscriptions out;
  if (at == 0)
    for (const std::size_t port : subscription_ports(parts.scene))
      out.networks.push_back(parts.endpoints.of_subscriptions(port));
  const std::size_t channels = parts.scene.state->decisions().size();
  SliceBudget budget(kOnwardRow);
  for (bool goes_on = true; goes_on && at < channels; ++at) {
    const std::size_t before = out.onward.size();
    add_channel(parts, at, out);
    goes_on = budget.made(out.onward.size() - before);
  }
  return {{std::move(out)}, at < channels};
}

}  // namespace

Response subscriptions(const SubscriptionsParts& parts, const Asker& /*asker*/,
                       const control::SubscriptionsRequest& /*request*/) {
  return parts.replies.in_slices(
      0, [parts, at = std::size_t{0}]() mutable { return some_onward(parts, at); });
}

}  // namespace mlcca::requests
