// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response networks(Context& context, const Asker& asker,
                  const control::NetworksRequest& /*request*/) {
  const auto make = [&context] {
    control::Networks out;
    for (std::size_t n = 0; n < context.scene.state->system().networks.size(); ++n)
      out.networks.push_back(network_report(*context.scene.state, n));
    return out;
  };
  if (context.channels.is_large()) return made_aside(context, asker, make);
  return make();
}

}  // namespace mlcca::requests
