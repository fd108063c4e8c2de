// SPDX-License-Identifier: BSD-2-Clause
// Counts of frames at gates and interfaces.
#pragma once
#include <cstdint>
#include <optional>

#include "core/gates/frame_reason.hpp"

namespace mlcca {

/// Frames of a port that belong to no slot of its gate.
struct UnknownFrames {
  std::uint64_t dropped = 0;
  std::uint64_t would_drop = 0;  ///< passed in audit mode
};

/// Frames of a port that were refused for a reason other than a missing slot, and that no slot has
/// counted.
struct Refusals {
  core::FrameReason reason = core::FrameReason::malformed;
  bool egress = false;
  UnknownFrames frames;
};

/// Refused frames of one direction of a port that no slot has counted.
struct WithoutSlot {
  bool egress = false;
  UnknownFrames all;    ///< for whatever reason
  UnknownFrames parts;  ///< of these: what continues a message that was not admitted
};

/// Frames of a delivery that its slots at this gateway have passed and dropped.
struct Frames {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t excess = 0;                      ///< more than was admitted, dropped or not
  std::uint64_t excess_dropped = 0;              ///< a part of dropped and of excess
  std::uint64_t would_drop = 0;                  ///< passed in audit mode; not a part of dropped
  std::uint64_t would_exceed = 0;                ///< a part of would_drop and of excess
  std::optional<core::FrameReason> last_reason;  ///< of the latest drop; nullopt: none yet
};

/// Counters of an interface about everything that was on the bus, each frame once.
struct BusCounters {
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;  ///< of the payload
};

}  // namespace mlcca
