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
  Bus bus;                                     ///< messages in the order of arbitration
  std::vector<core::can::Response> responses;  ///< of these, beside what counts
  std::vector<core::BusRow> rows;              ///< what is said of these
  std::vector<bool> by_admission;              ///< that is the bound: core/design/bus_responses.hpp
  std::vector<bool> fit;                       ///< in time, with room in the queue
  bool late = false;                           ///< one that counts is, or is not bounded
  bool met_alone = false;     ///< none is, but one would be if what is not counted sends
  bool kept_alone = false;    ///< a queue that is long enough would not be if that sends
  bool schedulable = true;    ///< all fit, as far as is known, and check refuses none for the bus
  std::string why_unbounded;  ///< a sentence, if one is not
  core::BusLoad load;         ///< 1e-6 of the bus time
  bool assigned = false;      ///< an order was searched for
  std::optional<std::vector<std::size_t>> order;  ///< highest priority first, if there is one
};

/// Messages that check refuses, whatever for.
[[nodiscard]] std::size_t refused_by_check(const AnalysedBus& analysed);

std::string write_text(const std::vector<AnalysedBus>& buses, Color color);
std::string write_json(const std::vector<AnalysedBus>& buses);

}  // namespace mlcca::tools::design
