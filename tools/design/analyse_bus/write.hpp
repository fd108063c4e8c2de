// SPDX-License-Identifier: BSD-2-Clause
// The result of analysing a bus, and its output as text and JSON.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can/analysis.hpp"
#include "tools/design/analyse_bus/bus.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::design {

/// A bus with its analysis. The vectors have an element for each message of the bus.
struct AnalysedBus {
  Bus bus;                                     ///< messages in order of arbitration
  std::vector<core::can::Response> responses;  ///< beside the messages that count
  std::vector<core::BusRow> rows;              ///< what is printed of each message
  std::vector<bool> by_admission;              ///< the bound is one that admission guarantees:
                                               ///< core/design/bus_responses.hpp
  std::vector<bool> fit;                       ///< in time, and its queue has room
  bool late = false;                           ///< a message that counts is late or has no bound
  bool met_alone = false;   ///< no message is late now, but one would be if messages that do not
                            ///< count are sent
  bool kept_alone = false;  ///< a queue that has room now would not if those are sent
  bool schedulable = true;  ///< all messages fit as far as is known, and check refuses none because
                            ///< of the bus
  std::string why_unbounded;                      ///< a sentence, if a message has no bound
  core::BusLoad load;                             ///< share of the bus time in 1e-6
  bool assigned = false;                          ///< an order of priorities was searched for
  std::optional<std::vector<std::size_t>> order;  ///< highest priority first; nullopt: there is
                                                  ///< none, or none was searched for
};

/// The number of messages that check refuses, for any reason.
[[nodiscard]] std::size_t refused_by_check(const AnalysedBus& analysed);

std::string write_text(const std::vector<AnalysedBus>& buses, Color color);
std::string write_json(const std::vector<AnalysedBus>& buses);

}  // namespace mlcca::tools::design
