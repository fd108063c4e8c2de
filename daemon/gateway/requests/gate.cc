// SPDX-License-Identifier: BSD-2-Clause
// Gate: what the gates hold.
#include <fmt/core.h>

#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {

Response gate(Context& context, const Asker& asker, const control::GateRequest& request) {
  const auto make = [&context, place = request.place]() -> Body {
    control::Gates out = context.gates.gates(*context.scene.state, place);
    if (out.gates.empty() && !place.empty())
      return invalid(
          fmt::format("there is no gated interface or network '{}' at this gateway (there are: "
                      "{})",
                      place, context.gates.gated_places()));
    return out;
  };
  if (context.channels.is_large()) return made_aside(context, asker, make);
  return make();
}

}  // namespace mlcca::requests
