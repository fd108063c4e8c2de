// SPDX-License-Identifier: BSD-2-Clause
// What the script of the page draws: the networks of a system, and the ways of its deliveries.
#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/design/check/report.hpp"

namespace mlcca::tools::design {

/// Deliveries that go the same way with the same outcome are one way.
struct Map {
  nlohmann::ordered_json json;      ///< {"places": […], "ways": […]}
  std::vector<std::size_t> way_of;  ///< of each delivery, its number among them
};

Map map_of(const SystemReport& report);

}  // namespace mlcca::tools::design
