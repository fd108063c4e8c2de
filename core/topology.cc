// SPDX-License-Identifier: BSD-2-Clause
#include "core/topology.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace mlcca::core {

std::span<const Place> hops_of(const Route& route) {
  std::span<const Place> all(route);
  if (!all.empty() && all.front().kind == Place::Kind::gateway) all = all.subspan(1);
  if (!all.empty() && all.back().kind == Place::Kind::gateway) all = all.first(all.size() - 1);
  return all;
}

Topology::Topology(const System& system)
    : of_network_(system.networks.size()), of_gateway_(system.gateways.size()) {
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    for (const Port& port : system.gateways[g].ports) {
      of_network_[port.network].push_back({Place::Kind::gateway, g});
      of_gateway_[g].push_back({Place::Kind::network, port.network});
    }
  }
  for (const DeclaredRoute& declared : system.routes) {
    const auto& there = declared.places;
    found_.insert_or_assign({there.front(), there.back()}, std::vector<Route>{there});
    found_.insert_or_assign({there.back(), there.front()},
                            std::vector<Route>{{there.rbegin(), there.rend()}});
  }
}

const std::vector<Place>& Topology::neighbours(Place p) const {
  return p.kind == Place::Kind::network ? of_network_[p.index] : of_gateway_[p.index];
}

const std::vector<Route>& Topology::routes(Place from, Place to) const {
  auto [it, fresh] = found_.try_emplace({from, to});
  if (fresh) it->second = search(from, to);
  return it->second;
}

std::vector<Route> Topology::search(Place from, Place to) const {
  if (from == to) return {{from}};
  std::vector<Route> found;
  std::deque<Route> open{{from}};
  for (std::size_t explored = 0;
       !open.empty() && found.size() < kMaxRoutes && explored < kMaxExplored; ++explored) {
    const Route partial = std::move(open.front());
    open.pop_front();
    for (const Place next : neighbours(partial.back())) {
      if (std::ranges::find(partial, next) != partial.end()) continue;
      Route longer = partial;
      longer.push_back(next);
      if (hops_of(longer).size() > kMaxHops) continue;
      if (next == to)
        found.push_back(std::move(longer));
      else
        open.push_back(std::move(longer));
    }
  }
  return found;
}

}  // namespace mlcca::core
