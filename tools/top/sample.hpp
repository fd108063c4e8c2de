// SPDX-License-Identifier: BSD-2-Clause
// What the daemon said at two moments, and the rows that follow from the difference.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::top {

/// The daemon's answers at one moment.
struct Sample {
  std::uint64_t at_ns = 0;  ///< of a clock that never goes back
  control::Status status;
  control::Networks networks;
  control::Channels channels;
  control::Reservations reservations;
};

/// One line of the screen: a delivery or a network. What is unknown is not there.
struct Row {
  std::string name;   ///< channel, or network
  std::string place;  ///< "from > to", or how many of its deliveries are granted
  std::string verdict;
  Style style = Style::plain;      ///< of the verdict
  std::optional<double> rate;      ///< frames that passed, 1/s
  std::optional<double> drops;     ///< frames, 1/s; in audit mode those that would be dropped
  std::optional<double> jitter;    ///< s
  std::optional<double> loss;      ///< share of the events
  std::optional<double> reserved;  ///< share of the resource that it takes the most of
  std::optional<double> used;      ///< share of what is reserved
  std::string subject;             ///< "0x…", for the filter
};

/// Without `before` there are no rates. Where a counter was restarted, its value is what came.
[[nodiscard]] std::vector<Row> rows_by_subject(const Sample* before, const Sample& now);
[[nodiscard]] std::vector<Row> rows_by_network(const Sample* before, const Sample& now);

}  // namespace mlcca::tools::top
