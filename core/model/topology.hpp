// SPDX-License-Identifier: BSD-2-Clause
// Finds routes: networks and gateways form a graph, in which routes with the fewest hops come
// first.
#pragma once
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Places in the order of travel, networks and gateways alternating, both ends included. A gateway
/// at an end hosts a local program; elsewhere it forwards.
using Route = std::vector<Place>;

/// The part of a route that events travel through. A gateway at either end is not a hop.
[[nodiscard]] std::span<const Place> hops_of(const Route& route);

/// Finds the routes between two places of a System, and keeps what it has found. The System is read
/// by the constructor only. Not safe for use by several threads, since routes() fills a cache.
class Topology {
 public:
  explicit Topology(const System& system);

  /// Returns the declared route if there is one. Otherwise the loop-free routes with the fewest
  /// hops first, at most kMaxRoutes; those of equal length in the order of the description. Empty
  /// if there is none within kMaxHops.
  [[nodiscard]] const std::vector<Route>& routes(Place from, Place to) const;

  /// The most alternative routes for one pair of places.
  static constexpr std::size_t kMaxRoutes = 16;
  /// The most partial routes that one search extends. It limits the cost in a dense graph.
  static constexpr std::size_t kMaxExplored = 65536;

 private:
  class Distances;
  class Search;
  [[nodiscard]] std::vector<Route> search(Place from, Place to) const;
  [[nodiscard]] const std::vector<Place>& neighbours(Place p) const;

  std::vector<std::vector<Place>> of_network_;
  std::vector<std::vector<Place>> of_gateway_;
  mutable std::map<std::pair<Place, Place>, std::vector<Route>> found_;
};

}  // namespace mlcca::core
