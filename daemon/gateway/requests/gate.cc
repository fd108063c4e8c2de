// SPDX-License-Identifier: BSD-2-Clause
// Gate: what the gates hold.
#include <fmt/core.h>

#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {

Response gate(const GateParts& parts, const Asker& asker, const control::GateRequest& request) {
  const auto make = [parts, place = request.place]() -> Body {
    control::Gates out = parts.gates.gates(*parts.scene.state, place);
    if (out.gates.empty() && !place.empty())
      return invalid(
          fmt::format("there is no gated interface or network '{}' at this gateway (there are: "
                      "{})",
                      place, parts.gates.gated_places()));
    return out;
  };
  return parts.replies.made(asker, parts.estimates.is_large(), make);
}

}  // namespace mlcca::requests
