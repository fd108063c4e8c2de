// SPDX-License-Identifier: BSD-2-Clause
// Routes: the routes through the networks, the links of meshes, and the rules of can-gw.
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/outlook.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/reservations.hpp"

namespace mlcca::requests {

Response routes(const RoutesParts& parts, const Asker& asker,
                const control::RoutesRequest& /*request*/) {
  const auto make = [parts](net::CanRules* rules) {
    const core::State& state = *parts.scene.state;
    control::Routes out = routes_report(state);
    for (std::size_t n = 0; n < state.system().networks.size(); ++n)
      if (const auto* table = parts.meshes.table(n))
        add_links(*parts.meshes.mesh(n), *table, state.system().networks[n].name,
                  parts.clock.monotonic_ns(), out);
    parts.endpoints.add_to(out);
    parts.forwarding.add_to(out, rules == nullptr ? parts.forwarding.read() : rules->read());
    return out;
  };
  if (!parts.estimates.is_large()) return make(nullptr);
  // The child needs its own socket, because it has none of the daemon's.
  return parts.replies.aside(asker, [make] {
    net::KernelCanRules rules;
    return make(&rules);
  });
}

}  // namespace mlcca::requests
