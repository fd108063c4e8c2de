// SPDX-License-Identifier: BSD-2-Clause
// What gates and interfaces have counted.
#pragma once
#include <cstdint>
#include <string>

namespace mlcca {

/// Frames of a port that belong to no slot of its gate.
struct UnknownFrames {
  std::uint64_t dropped = 0;
  std::uint64_t would_drop = 0;  ///< let through by audit mode
};

/// Frames of a port that were refused for a reason that is of no slot, and not for want of one.
struct Refusals {
  const char* reason = "";  ///< in words
  bool egress = false;
  UnknownFrames frames;
};

/// Frames that the slots of a delivery have passed and dropped at this gateway.
struct Frames {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t excess = 0;          ///< more than was admitted, dropped or not
  std::uint64_t excess_dropped = 0;  ///< part of both
  std::uint64_t would_drop = 0;      ///< let through by audit mode; not part of dropped
  std::uint64_t would_exceed = 0;    ///< part of would_drop and of excess
  std::string last_reason;           ///< of the latest drop; empty: none
};

/// Counters of an interface, of everything that was on the bus: each frame once.
struct BusCounters {
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;  ///< of payload
};

}  // namespace mlcca
