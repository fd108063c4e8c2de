// SPDX-License-Identifier: BSD-2-Clause
// How long one frame whose content is known holds a CAN bus: to the bit, where frame.hpp has
// bounds.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/can/frame.hpp"

namespace mlcca::core::can {

struct WireFrame {
  std::uint32_t id = 0;  ///< 11 or 29 bits, without flags
  bool extended = false;
  bool fd = false;
  bool remote = false;    ///< classic: a request, without payload
  bool switches = false;  ///< FD: the data phase has a rate of its own (BRS)
  bool passive = false;   ///< FD: ESI, the sender is error-passive
  std::uint8_t size = 0;  ///< payload bytes, of a request those that are asked for
  std::array<std::uint8_t, 64> data{};
};

/// Bits from the start of the frame to the end of the intermission, stuff bits included. The bits
/// in which the rate changes (BRS and the CRC delimiter) are together one of each rate.
struct WireLength {
  unsigned slow = 0;
  unsigned fast = 0;
  bool operator==(const WireLength&) const = default;
};

[[nodiscard]] WireLength wire_length(const WireFrame& frame);

/// Bits behind the acknowledgement that a frame counts as sent before: the intermission.
inline constexpr unsigned kIntermission = 3;

/// Nanoseconds, rounded to the nearest; kNever if the bit rate is unknown.
[[nodiscard]] Time wire_time(const Timing& timing, WireLength length);

}  // namespace mlcca::core::can
