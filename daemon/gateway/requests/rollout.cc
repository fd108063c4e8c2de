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

Response rollout(const RolloutParts& parts, const Asker& asker,
                 const control::RolloutRequest& request) {
  if (parts.membership == nullptr) return invalid(kAlone);
  if (const std::string why = parts.membership->rollout_bar(); !why.empty())
    return failed("nothing was changed: " + why);
  return parts.membership->rollout().take(asker, request, parts.membership->own_member());
}

Response rollout_state(const RolloutParts& parts, const Asker& /*asker*/,
                       const control::RolloutStateRequest& /*request*/) {
  if (parts.membership == nullptr) return invalid(kAlone);
  return parts.membership->rollout().state(parts.membership->member());
}

}  // namespace mlcca::requests
