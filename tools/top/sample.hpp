// SPDX-License-Identifier: BSD-2-Clause
// The answers of the daemon at two moments, and the rows that result from their difference.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "tools/table.hpp"

namespace mlcca::tools::top {

/// The answers of the daemon at one moment.
struct Sample {
  std::uint64_t at_ns = 0;  ///< of a monotonic clock
  control::Status status;
  control::Networks networks;
  control::Channels channels;
  control::Reservations reservations;
};

/// A line of the screen: a delivery or a network. An unknown value is nullopt.
struct Row {
  std::string name;   ///< name of a channel or network
  std::string place;  ///< "from > to", or how many deliveries of the network are granted
  std::string verdict;
  Style style = Style::plain;   ///< of the verdict
  std::optional<double> rate;   ///< frames that passed, 1/s
  std::optional<double> drops;  ///< frames dropped, in audit mode frames that would be dropped, 1/s
  std::optional<double> jitter;    ///< seconds
  std::optional<double> loss;      ///< share of the events
  std::optional<double> reserved;  ///< share of the resource of which it takes the most
  std::optional<double> used;      ///< share of its reservation
  std::string subject;             ///< "0x…", for the filter
};

/// Rows without rates if `before` is null. A counter that was restarted counts from 0.
[[nodiscard]] std::vector<Row> rows_by_subject(const Sample* before, const Sample& now);
[[nodiscard]] std::vector<Row> rows_by_network(const Sample* before, const Sample& now);

}  // namespace mlcca::tools::top
