// SPDX-License-Identifier: BSD-2-Clause
// A system as a graph for Graphviz: networks, gateways, who sits there, channels by outcome.
#pragma once
#include <cstddef>
#include <string>

#include "tools/design/check/report.hpp"

namespace mlcca::tools::design {

struct Drawing {
  std::string source;        ///< in the language of dot
  bool aggregated = false;   ///< an edge stands for all channels between two places
  std::size_t left_out = 0;  ///< networks, gateways, ports and edges that are not drawn
};

/// Up to kMaxSingle deliveries each has an edge from publisher to subscriber; with more, the
/// channels between the same two places with the same outcome share one. At most kMaxNodes places,
/// kMaxEdges ports and kMaxEdges channels are drawn. `number` makes the ids of the elements unique
/// on a page.
Drawing draw(const SystemReport& system, std::size_t number);

inline constexpr std::size_t kMaxSingle = 60;
inline constexpr std::size_t kMaxNodes = 120;
inline constexpr std::size_t kMaxEdges = 200;

}  // namespace mlcca::tools::design
