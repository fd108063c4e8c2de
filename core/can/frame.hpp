// SPDX-License-Identifier: BSD-2-Clause
// How long a frame holds a CAN bus at most, and which of two frames wins arbitration.
#pragma once
#include <cstdint>

namespace mlcca::core::can {

/// Nanoseconds; bounds are rounded up.
using Time = std::uint64_t;

/// The time that results from an unknown bit rate. It is longer than any that is analysed.
inline constexpr Time kNever = ~Time{0};

/// Bit rates of a bus in bit/s. `bitrate` 0: unknown. `data_bitrate` is that of the data phase of
/// FD frames; if it is 0 or less than `bitrate`, FD frames do not change the rate.
struct Timing {
  std::uint32_t bitrate = 0;
  std::uint32_t data_bitrate = 0;
  bool operator==(const Timing&) const = default;
};

/// The format of a classic or FD frame.
struct FrameForm {
  bool extended = false;  ///< 29-bit identifier
  bool fd = false;        ///< FD format, with a change of rate where the bus has a data bit rate
};

/// The smallest payload of an FD frame that holds so many bytes, at most 64.
[[nodiscard]] unsigned fd_size(unsigned bytes);

/// The longest time (ns) that a data frame with `bytes` of payload holds the bus, stuff bits and
/// the three bits of intermission included. FD payloads are rounded up to the next existing size;
/// more than 8 (FD: 64) bytes count as 8 (64). kNever if the bit rate is unknown.
///
/// Classic: Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability analysis:
/// Refuted, revisited and revised", Real-Time Systems 35, 2007, equation 1. FD: counted from ISO
/// 11898-1:2015, see frame.cc. docs/explanation/can-analysis.md has both.
[[nodiscard]] Time frame_time(const Timing& timing, FrameForm form, unsigned bytes);

/// The same for a CAN XL frame with 1 to 2048 bytes (fields from CiA 610-1), see frame.cc.
[[nodiscard]] Time xl_frame_time(const Timing& timing, unsigned bytes);

/// The longest frame possible on a bus, of either identifier length; kNever if the bit rate is
/// unknown.
[[nodiscard]] Time longest_frame(const Timing& timing, bool fd, bool xl = false);

/// The time (ns) of one bit of the arbitration phase; kNever if the bit rate is unknown.
[[nodiscard]] Time bit_time(const Timing& timing);

/// Maps an identifier (11 or 29 bits, without flags) to a number so that the smaller number wins
/// arbitration. An 11-bit frame wins against a 29-bit frame with the same first 11 bits.
[[nodiscard]] std::uint32_t arbitration(std::uint32_t id, bool extended);

}  // namespace mlcca::core::can
