// SPDX-License-Identifier: BSD-2-Clause
// How long a frame holds a CAN bus, and which of two frames wins the bus.
#pragma once
#include <cstdint>

namespace mlcca::core::can {

/// Nanoseconds. Bounds are rounded up.
using Time = std::uint64_t;

/// What a time is when the bit rate is unknown, and longer than any that is analysed.
inline constexpr Time kNever = ~Time{0};

/// Bit rates of a bus, bit/s. 0 in `bitrate`: unknown. `data_bitrate` is that of the data phase of
/// FD frames; 0 or less than `bitrate`: FD frames do not change the rate.
struct Timing {
  std::uint32_t bitrate = 0;
  std::uint32_t data_bitrate = 0;
  bool operator==(const Timing&) const = default;
};

struct FrameForm {
  bool extended = false;  ///< 29-bit identifier
  bool fd = false;        ///< FD format, with the change of rate wherever the bus has one
};

/// The smallest size of an FD frame that has room for so many bytes, at most 64.
[[nodiscard]] unsigned fd_size(unsigned bytes);

/// Longest time that a data frame of `bytes` payload bytes holds the bus, stuff bits and the three
/// bits of intermission included. FD: bytes are rounded up to the next size that exists. More than
/// 8 (FD: 64) count as 8 (64). kNever if the bit rate is unknown.
///
/// Classic frames: Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability
/// analysis: Refuted, revisited and revised", Real-Time Systems 35, 2007, equation 1. FD frames:
/// counted from ISO 11898-1:2015, see frame.cc. docs/explanation/can-analysis.md has both.
[[nodiscard]] Time frame_time(const Timing& timing, FrameForm form, unsigned bytes);

/// The same for a CAN XL frame of 1 to 2048 bytes, see frame.cc.
[[nodiscard]] Time xl_frame_time(const Timing& timing, unsigned bytes);

/// The longest frame that a bus can carry, of either identifier length; kNever as above.
[[nodiscard]] Time longest_frame(const Timing& timing, bool fd, bool xl = false);

/// One bit of the arbitration phase; kNever as above.
[[nodiscard]] Time bit_time(const Timing& timing);

/// One number for an identifier (11 or 29 bits, without flags): the smaller one wins the bus. An
/// 11-bit frame beats a 29-bit frame whose first 11 bits are the same.
[[nodiscard]] std::uint32_t arbitration(std::uint32_t id, bool extended);

}  // namespace mlcca::core::can
