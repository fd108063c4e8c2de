// SPDX-License-Identifier: BSD-2-Clause
// Maps obstacles and failed rows to kinds of findings.
#pragma once
#include "core/design/findings.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

[[nodiscard]] constexpr FindingId id_of(Obstacle obstacle) {
  switch (obstacle) {
    case Obstacle::unbound:
      return FindingId::unbound;
    case Obstacle::no_node:
      return FindingId::no_node;
    case Obstacle::too_long:
      return FindingId::too_long;
    case Obstacle::no_data_rate:
      return FindingId::no_data_rate;
    case Obstacle::sender_twice:
      return FindingId::sender_twice;
    case Obstacle::echo:
      return FindingId::echo;
    case Obstacle::no_traffic:
    case Obstacle::no_period:
      return FindingId::no_traffic;
    default:
      return FindingId::no_route;
  }
}

[[nodiscard]] constexpr FindingId id_of(Against against) {
  switch (against) {
    case Against::hop:
      return FindingId::hop_unfit;
    case Against::end_to_end:
      return FindingId::route_unfit;
    case Against::traffic:
      return FindingId::traffic_mismatch;
    case Against::overhearing:
      return FindingId::overhearing_unfit;
    case Against::capacity:
      return FindingId::capacity;
    case Against::schedule:
      return FindingId::deadline_missed;
    case Against::medium_time:
      return FindingId::medium_time;
  }
  return FindingId::rule;
}

}  // namespace mlcca::core
