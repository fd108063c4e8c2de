// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response networks(const NetworksParts& parts, const Asker& asker,
                  const control::NetworksRequest& /*request*/) {
  const auto make = [parts] {
    control::Networks out;
    for (std::size_t n = 0; n < parts.scene.state->system().networks.size(); ++n)
      out.networks.push_back(network_report(*parts.scene.state, n));
    return out;
  };
  return parts.replies.made(asker, parts.estimates.is_large(), make);
}

}  // namespace mlcca::requests
