// SPDX-License-Identifier: BSD-2-Clause
// A CAN bus that is analysed: from a table of messages or from the description of a system.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::tools::design {

struct BusMessage {
  std::string name;
  std::uint32_t id = 0;  ///< 11 or 29 bits
  bool extended = false;
  std::uint64_t bytes = 0;  ///< payload of one frame; of a described publisher, of one event
  core::can::Message message;
};

struct Bus {
  std::string network;  ///< empty: from a table
  core::can::Assumptions assumptions;
  std::vector<BusMessage> messages;
};

/// What the command line states of a bus. It goes before what a description states.
struct BusOptions {
  std::string network;             ///< only this one; empty: all
  std::uint32_t bitrate = 0;       ///< bit/s, 0: not stated
  std::uint32_t data_bitrate = 0;  ///< bit/s, 0: not stated
  bool unknown_senders = false;
  std::optional<std::uint32_t> background;  ///< 1e-6 of the bus time
  std::optional<core::FaultHypothesis> faults;
};

/// Buses, or why there are none: each problem is a line that names a place and what would be right.
struct Buses {
  std::vector<Bus> buses;
  std::vector<std::string> problems;
};

/// The messages of a table with the columns name, id, extended, bytes, period_us, deadline_us,
/// jitter_us and, if wanted, fd and frames, in any order. `file` stands for it in problems. The bit
/// rate must be stated.
Buses read_table(std::string_view text, const std::string& file, const BusOptions& options);

/// The CAN networks of a description, with the described publishers whose events cross them.
Buses read_description(const std::string& file, const BusOptions& options);

}  // namespace mlcca::tools::design
