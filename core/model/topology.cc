// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/topology.hpp"

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

/// The number of steps from each place to one destination.
class Topology::Distances {
 public:
  Distances(const Topology& topology, Place to)
      : of_network_(topology.of_network_.size(), kNever),
        of_gateway_(topology.of_gateway_.size(), kNever) {
    std::deque<Place> open{to};
    at(to) = 0;
    for (; !open.empty(); open.pop_front()) {
      const std::size_t next = at(open.front()) + 1;
      for (const Place p : topology.neighbours(open.front())) {
        if (at(p) != kNever) continue;
        at(p) = next;
        open.push_back(p);
      }
    }
  }

  std::size_t& at(Place p) {
    return p.kind == Place::Kind::network ? of_network_[p.index] : of_gateway_[p.index];
  }

  static constexpr std::size_t kNever = 1U << 20U;

 private:
  std::vector<std::size_t> of_network_;
  std::vector<std::size_t> of_gateway_;
};

/// Finds routes depth first, one length after the other. It never goes to a place from which `to`
/// cannot be reached in the remaining steps, so the cost depends on the routes that exist and not
/// on dead ends.
class Topology::Search {
 public:
  Search(const Topology& topology, Place from, Place to)
      : topology_(topology), to_(to), steps_to_(topology, to) {
    route_.push_back(from);
  }

  std::vector<Route> run() {
    // Networks and gateways alternate, so all routes between two places have the same parity.
    for (std::size_t steps = steps_to_.at(route_.front()); steps <= kMostSteps && !enough();
         steps += 2)
      extend(steps);
    return std::move(found_);
  }

 private:
  static constexpr std::size_t kMostSteps = kMaxHops + 1;  // a gateway at each end is no hop

  [[nodiscard]] bool enough() const {
    return found_.size() == kMaxRoutes || explored_ == kMaxExplored;
  }

  /// Finds every way to continue the route to `to` in exactly that many steps.
  void extend(std::size_t steps) {
    ++explored_;
    if (steps == 0) {
      if (hops_of(route_).size() <= kMaxHops) found_.push_back(route_);
      return;
    }
    for (const Place next : topology_.neighbours(route_.back())) {
      if (enough()) return;
      if (steps_to_.at(next) >= steps || (next == to_) != (steps == 1)) continue;
      if (std::ranges::find(route_, next) != route_.end()) continue;
      route_.push_back(next);
      extend(steps - 1);
      route_.pop_back();
    }
  }

  const Topology& topology_;
  Place to_;
  Distances steps_to_;
  Route route_;
  std::vector<Route> found_;
  std::size_t explored_ = 0;
};

std::vector<Route> Topology::search(Place from, Place to) const {
  if (from == to) return {{from}};
  return Search(*this, from, to).run();
}

}  // namespace mlcca::core
