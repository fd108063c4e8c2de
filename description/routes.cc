// SPDX-License-Identifier: BSD-2-Clause
// Resolves declared routes: each step must lead from a network to a gateway with a port on it, or
// back.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "description/resolve.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using core::Place;

class Routes {
 public:
  Routes(Resolved& to, Problems& problems) : to_(to), problems_(problems) {}

  void add(const RouteDraft& from) {
    core::DeclaredRoute route{{}, from.origin};
    for (const auto& hop : from.places) {
      const auto place = place_named(hop);
      if (!place) return;
      if (std::ranges::find(route.places, *place) != route.places.end()) {
        problems_.add(hop.origin, "Route",
                      fmt::format("{} is on this route twice: a route has no loop", hop.place),
                      FindingId::rule);
        return;
      }
      if (!route.places.empty() && !adjacent(route.places.back(), *place)) {
        refuse_step(hop, route.places.back(), *place);
        return;
      }
      route.places.push_back(*place);
    }
    if (is_fresh(route)) to_.system.routes.push_back(std::move(route));
  }

 private:
  std::optional<Place> place_named(const HopDraft& hop) {
    if (const auto network = to_.networks.find(hop.place))
      return Place{Place::Kind::network, *network};
    if (const auto gateway = to_.gateways.find(hop.place))
      return Place{Place::Kind::gateway, *gateway};
    to_.networks.find(hop.place, hop.origin, "Route", problems_);
    return std::nullopt;
  }

  [[nodiscard]] bool adjacent(Place a, Place b) const {
    if (a.kind == b.kind) return false;
    if (a.kind == Place::Kind::network) std::swap(a, b);
    return to_.system.gateways[a.index].port_on(b.index) != nullptr;
  }

  [[nodiscard]] const std::string& name_of(Place p) const {
    return p.kind == Place::Kind::network ? to_.system.networks[p.index].name
                                          : to_.system.gateways[p.index].name;
  }

  void refuse_step(const HopDraft& hop, Place from, Place to) {
    const bool two = from.kind == to.kind;
    problems_.add(
        hop.origin, "Route",
        two ? fmt::format("{} and {} are both {}s: a {} stands between them", name_of(from),
                          name_of(to), from.kind == Place::Kind::network ? "network" : "gateway",
                          from.kind == Place::Kind::network ? "gateway" : "network")
            : fmt::format("no step leads from {} to {}: the gateway has no port on that "
                          "network",
                          name_of(from), name_of(to)));
  }

  bool is_fresh(const core::DeclaredRoute& route) {
    auto ends = std::minmax(route.places.front(), route.places.back());
    const auto [it, fresh] = declared_.try_emplace({ends.first, ends.second}, route.origin);
    if (!fresh)
      problems_.add(route.origin, "Route",
                    fmt::format("the route between {} and {} is already declared in {}",
                                name_of(route.places.front()), name_of(route.places.back()),
                                line_words(to_.system, route.origin, it->second)),
                    FindingId::name_twice);
    return fresh;
  }

  Resolved& to_;
  Problems& problems_;
  std::map<std::pair<Place, Place>, core::Origin> declared_;
};

}  // namespace

void add_routes(const Draft& draft, Resolved& to, Problems& problems) {
  Routes routes(to, problems);
  for (const auto& route : draft.routes) routes.add(route);
}

}  // namespace mlcca::description
