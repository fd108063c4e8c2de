// SPDX-License-Identifier: BSD-2-Clause
// The data for the drawing of the page: the networks of a system and the ways of its deliveries.
#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/design/check/report.hpp"

namespace mlcca::tools::design {

/// The map. Deliveries with the same route and outcome share a way.
struct Map {
  nlohmann::ordered_json json;      ///< {"places": […], "ways": […]}
  std::vector<std::size_t> way_of;  ///< for each delivery, the index of its way
};

Map map_of(const SystemReport& report);

}  // namespace mlcca::tools::design
