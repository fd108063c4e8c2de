// SPDX-License-Identifier: BSD-2-Clause
// The exact length of one CAN frame with known content, while frame.hpp has upper bounds.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/can/frame.hpp"

namespace mlcca::core::can {

/// A CAN frame with its content.
struct WireFrame {
  std::uint32_t id = 0;  ///< 11 or 29 bits without flags
  bool extended = false;
  bool fd = false;
  bool remote = false;    ///< classic: a request, without payload
  bool switches = false;  ///< FD: the data phase has its own bit rate (BRS)
  bool passive = false;   ///< FD: the ESI bit, the sender is error-passive
  std::uint8_t size = 0;  ///< payload bytes; of a remote frame the requested number
  std::array<std::uint8_t, 64> data{};
};

/// Bits from the start of the frame to the end of the intermission, stuff bits included, at the bit
/// rate of arbitration (slow) and of the data phase (fast). The two bits during which the rate
/// changes (BRS and the CRC delimiter) count as one bit of each.
struct WireLength {
  unsigned slow = 0;
  unsigned fast = 0;
  bool operator==(const WireLength&) const = default;
};

[[nodiscard]] WireLength wire_length(const WireFrame& frame);

/// Bits of the intermission, which follow when a frame has already been sent.
inline constexpr unsigned kIntermission = 3;

/// The duration in ns, rounded to the nearest; kNever if the bit rate is unknown.
[[nodiscard]] Time wire_time(const Timing& timing, WireLength length);

}  // namespace mlcca::core::can
