// SPDX-License-Identifier: BSD-2-Clause
// Which checks the compiler shall make for a unit: between whom, and over which hops.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/topology.hpp"
#include "tools/design/generate/unit.hpp"

namespace mlcca::tools::design {

/// A network or gateway that events cross.
struct RouteHop {
  core::Place place;
  std::uint16_t frames = 1;  ///< of one event
};

/// A publisher and a subscriber of the same channel, one of them of the unit; or one end alone,
/// where the system has nobody on the other side.
struct Pair {
  std::optional<End> publisher;
  std::optional<End> subscriber;
  std::vector<RouteHop> hops;  ///< empty: both on one gateway, or there is no way
  bool connected = true;       ///< false: there is no way
};

/// All of a unit, in the order of its ends. Of several ways of the same pair the first that fits is
/// taken, as the gateway does, and the first of all if none does.
std::vector<Pair> pairs_of(const core::System& system, const core::Topology& topology,
                           const Unit& unit);

}  // namespace mlcca::tools::design
