// SPDX-License-Identifier: BSD-2-Clause
// Rollout: one description for all gateways of a cluster.
#include "daemon/gateway/rollout.hpp"

#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

constexpr const char* kAlone =
    "this gateway shares nothing by a store: 'mlccactl reload' reads its description again";

}  // namespace

Response rollout(Context& context, const Asker& asker, const control::RolloutRequest& request) {
  if (context.membership == nullptr) return invalid(kAlone);
  if (const std::string why = context.membership->rollout_bar(); !why.empty())
    return failed("nothing was changed: " + why);
  return context.membership->rollout().take(asker, request, context.membership->member());
}

Response rollout_state(Context& context, const Asker& /*asker*/,
                       const control::RolloutStateRequest& /*request*/) {
  if (context.membership == nullptr) return invalid(kAlone);
  return context.membership->rollout().state(context.membership->member());
}

}  // namespace mlcca::requests
