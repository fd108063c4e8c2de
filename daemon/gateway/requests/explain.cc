// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response explain(Context& context, const Asker& asker, const control::ExplainRequest& request) {
  const auto channel = channel_named(*context.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  return known(context, asker, {*channel, {}, {}, {}});
}

}  // namespace mlcca::requests
