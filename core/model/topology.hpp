// SPDX-License-Identifier: BSD-2-Clause
// Which way from one place to another: networks and gateways as a graph, routes by fewest hops.
#pragma once
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Places in order of travel, alternating networks and gateways, both ends included. A gateway at
/// an end is where a local program sits; elsewhere it forwards.
using Route = std::vector<Place>;

/// The part of a route that an event travels through: a gateway at an end is not a hop.
[[nodiscard]] std::span<const Place> hops_of(const Route& route);

class Topology {
 public:
  explicit Topology(const System& system);

  /// The declared route, where there is one. Otherwise routes without a loop, fewest hops first, at
  /// most kMaxRoutes; equal lengths in the order of the description. Empty when there is none
  /// within kMaxHops.
  [[nodiscard]] const std::vector<Route>& routes(Place from, Place to) const;

  /// Alternatives that are tried for one pair of places.
  static constexpr std::size_t kMaxRoutes = 16;
  /// Partial routes that one search may extend, so that a dense graph stays cheap.
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
