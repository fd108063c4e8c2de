// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/frame.hpp"

#include <algorithm>
#include <array>

namespace mlcca::core::can {
namespace {

constexpr Time kSecond = 1'000'000'000;

// Classic frames. Stuff bits may be inserted from the start of the frame to the end of the CRC: 34
// bits and the payload, 54 with a 29-bit identifier. Delimiters, acknowledgement, end of frame and
// intermission (13 bits) are never stuffed. The first stuff bit needs five bits, each further one
// four, because a stuff bit is the first of the next five.
constexpr unsigned kStuffedStandard = 34;
constexpr unsigned kStuffedExtended = 54;
constexpr unsigned kTail = 13;

// FD frames, first part at the arbitration rate: start of frame to BRS. FDF is recessive between
// dominant bits, so no five equal bits end after IDE (11 bit) or RRS (29 bit): only the 13 or 33
// bits up to RRS can be followed by stuff bits (IDE adds none).
constexpr unsigned kFdHeadStandard = 17;
constexpr unsigned kFdHeadExtended = 36;
constexpr unsigned kFdHeadStuffStandard = 3;
constexpr unsigned kFdHeadStuffExtended = 8;
// Last part at the arbitration rate: CRC delimiter, acknowledgement and its delimiter, end of frame
// and intermission, and two more bits, because nodes accept a CRC delimiter and an acknowledgement
// of two bits each to compensate phase shifts.
constexpr unsigned kFdTail = 1 + 1 + 1 + 7 + 3 + 2;
// Data phase: ESI and DLC, the payload, and dynamic stuff bits in the sequence BRS, ESI, DLC,
// payload: the first after five bits, then one for each four, 1 + 2 per payload byte. Then follow a
// stuff count of 4 bits and a CRC of 17 or 21 bits, with a fixed stuff bit before the first of them
// and after each fourth: 21 + 6 or 25 + 7 bits.
constexpr unsigned kFdControl = 1 + 4 + 1;
constexpr unsigned kFdShortCrc = 27;
constexpr unsigned kFdLongCrc = 32;
constexpr unsigned kFdShortCrcBytes = 16;

// CAN XL (fields of CiA 610-1), first and last part at the arbitration rate: start of frame,
// priority, RRS, IDE, FDF, XLF and resXL with a stuff bit for each four behind the first five, ADH;
// then the four bits of the return to that rate (DAS), acknowledgement and its delimiter, end of
// frame, intermission, and two bits as for FD.
constexpr unsigned kXlSlow = 1 + 11 + 5 + 4 + 1 + 4 + 2 + 7 + 3 + 2;
// CAN XL at the data rate with a stuff bit after each ten bits: DL1, SDT, SEC, DLC, stuff count,
// CRC of the preface, VCID, acceptance field, payload, CRC of the frame. Not stuffed: DH1 and DH2,
// and the format check pattern.
constexpr unsigned kXlStuffed = 1 + 8 + 1 + 11 + 3 + 13 + 8 + 32 + 32;
constexpr unsigned kXlPlain = 2 + 4;
constexpr unsigned kXlRun = 10;
constexpr unsigned kXlMost = 2048;

constexpr std::array<unsigned, 16> kFdSizes = {0, 1,  2,  3,  4,  5,  6,  7,
                                               8, 12, 16, 20, 24, 32, 48, 64};

Time time_of(unsigned bits, std::uint32_t rate) { return (bits * kSecond + rate - 1) / rate; }

unsigned classic_bits(bool extended, unsigned bytes) {
  const unsigned stuffed =
      (extended ? kStuffedExtended : kStuffedStandard) + 8 * std::min(bytes, kFdSizes[8]);
  return stuffed + kTail + (stuffed - 1) / 4;
}

}  // namespace

unsigned fd_size(unsigned bytes) {
  return *std::ranges::lower_bound(kFdSizes, std::min(bytes, kFdSizes.back()));
}

Time frame_time(const Timing& timing, FrameForm form, unsigned bytes) {
  if (timing.bitrate == 0) return kNever;
  if (!form.fd) return time_of(classic_bits(form.extended, bytes), timing.bitrate);
  const unsigned size = fd_size(bytes);
  const unsigned slow = form.extended ? kFdHeadExtended + kFdHeadStuffExtended + kFdTail
                                      : kFdHeadStandard + kFdHeadStuffStandard + kFdTail;
  const unsigned fast =
      kFdControl + 10 * size + (size <= kFdShortCrcBytes ? kFdShortCrc : kFdLongCrc);
  if (timing.data_bitrate <= timing.bitrate) return time_of(slow + fast, timing.bitrate);
  return time_of(slow, timing.bitrate) + time_of(fast, timing.data_bitrate);
}

Time xl_frame_time(const Timing& timing, unsigned bytes) {
  if (timing.bitrate == 0) return kNever;
  const unsigned stuffed = kXlStuffed + 8 * std::clamp(bytes, 1U, kXlMost);
  const unsigned fast = kXlPlain + stuffed + (stuffed + kXlRun - 1) / kXlRun;
  return time_of(kXlSlow, timing.bitrate) +
         time_of(fast, std::max(timing.bitrate, timing.data_bitrate));
}

Time longest_frame(const Timing& timing, bool fd, bool xl) {
  if (xl) return std::max(longest_frame(timing, fd), xl_frame_time(timing, kXlMost));
  const Time classic = frame_time(timing, {.extended = true, .fd = false}, kFdSizes[8]);
  if (!fd) return classic;
  return std::max(classic, frame_time(timing, {.extended = true, .fd = true}, kFdSizes.back()));
}

Time bit_time(const Timing& timing) {
  return timing.bitrate == 0 ? kNever : time_of(1, timing.bitrate);
}

std::uint32_t arbitration(std::uint32_t id, bool extended) {
  constexpr unsigned further_bits = 18;  // of a 29-bit identifier, behind the first 11
  constexpr std::uint32_t longer = 1U << further_bits;
  constexpr std::uint32_t further = longer - 1;
  if (!extended) return id << (further_bits + 1);
  return (id >> further_bits) << (further_bits + 1) | longer | (id & further);
}

}  // namespace mlcca::core::can
