// SPDX-License-Identifier: BSD-2-Clause
// The analysis of buses as text and as JSON.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can/analysis.hpp"
#include "tools/design/analyse_bus/bus.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

struct AnalysedBus {
  Bus bus;                                        ///< messages in the order of arbitration
  std::vector<core::can::Response> responses;     ///< of these
  std::vector<bool> in_time;                      ///< with room in the queue
  bool schedulable = true;                        ///< all of them
  std::uint64_t load = 0;                         ///< 1e-6 of the bus time
  bool assigned = false;                          ///< an order was looked for
  std::optional<std::vector<std::size_t>> order;  ///< highest priority first, if there is one
};

std::string write_text(const std::vector<AnalysedBus>& buses, Color color);
std::string write_json(const std::vector<AnalysedBus>& buses);

}  // namespace mlcca::tools::design
