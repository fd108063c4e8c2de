// SPDX-License-Identifier: BSD-2-Clause
// Frames are built bit by bit and stuffed; the formulas may never be below.
#include "core/can/frame.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <vector>

namespace mlcca::core::can {
namespace {

enum Bit : int { dominant = 0, recessive = 1, any = 2 };

struct Piece {
  std::vector<Bit> bits;
  void add(Bit bit, unsigned count = 1) { bits.insert(bits.end(), count, bit); }
  void add_code(unsigned code, unsigned width) {
    for (unsigned i = width; i-- > 0;) bits.push_back((code >> i & 1U) != 0 ? recessive : dominant);
  }
};

/// Longest time of a sequence with the bits that dynamic stuffing adds, over all values of its free
/// bits: after five equal bits one of the other value, which is the first of the next run. Bits
/// from `change` on, and stuff bits behind them, take `fast`. `stuff_at_end`: whether the last bit
/// may be followed by a stuff bit.
Time longest_stuffed(const Piece& piece, std::size_t change, Time slow, Time fast,
                     bool stuff_at_end) {
  using State = std::pair<int, unsigned>;  // last value, length of its run
  std::map<State, Time> states = {{{recessive, 0}, 0}};
  for (std::size_t i = 0; i < piece.bits.size(); ++i) {
    const Time cost = i < change ? slow : fast;
    std::map<State, Time> next;
    for (const auto& [state, time] : states)
      for (int value = 0; value < 2; ++value) {
        if (piece.bits[i] != any && piece.bits[i] != value) continue;
        State now{value, state.first == value ? state.second + 1 : 1};
        Time then = time + cost;
        if (now.second == 5 && (i + 1 < piece.bits.size() || stuff_at_end)) {
          now = {1 - value, 1};
          then += cost;
        }
        next[now] = std::max(next[now], then);
      }
    states = std::move(next);
  }
  Time longest = 0;
  for (const auto& [state, time] : states) longest = std::max(longest, time);
  return longest;
}

/// Start of frame to the bit in front of the one that differs in classic and FD frames.
Piece head(bool extended, Bit remote) {
  Piece p;
  p.add(dominant);  // start of frame
  p.add(any, 11);
  if (extended) {
    p.add(recessive, 2);  // SRR, IDE
    p.add(any, 18);
    p.add(remote);
  } else {
    p.add(remote);
    p.add(dominant);  // IDE
  }
  return p;
}

Time built_classic(bool extended, unsigned bytes, Time bit) {
  Piece p = head(extended, dominant);
  p.add(dominant, extended ? 2 : 1);  // reserved
  p.add_code(bytes, 4);
  p.add(any, 8 * bytes);
  p.add(any, 15);  // the CRC may be anything: more than what a real one is
  const unsigned tail = 1 + 2 + 7 + 3;
  return longest_stuffed(p, p.bits.size(), bit, bit, true) + tail * bit;
}

Time built_fd(bool extended, unsigned code, unsigned bytes, Time slow, Time fast) {
  Piece p = head(extended, dominant);
  p.add(recessive);  // FDF
  p.add(dominant);   // reserved
  p.add(recessive);  // BRS
  const std::size_t change = p.bits.size();
  p.add(any);  // ESI
  p.add_code(code, 4);
  p.add(any, 8 * bytes);
  unsigned crc = 0;  // stuff count and CRC with a fixed stuff bit before each four bits
  for (unsigned i = 0; i < 4U + (bytes > 16 ? 21 : 17); ++i) crc += i % 4 == 0 ? 2 : 1;
  const unsigned tail = 1 + 2 + 7 + 3;
  return longest_stuffed(p, change, slow, fast, false) + crc * fast + tail * slow;
}

TEST(Frame, ClassicFormulaIsTheLongestOfAllRealFrames) {
  const Timing timing{.bitrate = 1'000'000};
  for (const bool extended : {false, true})
    for (unsigned bytes = 0; bytes <= 8; ++bytes) {
      const Time built = built_classic(extended, bytes, 1000);
      const Time stated = frame_time(timing, {.extended = extended}, bytes);
      EXPECT_GE(stated, built) << extended << ' ' << bytes;
      // Fixed bits (SRR and IDE, the length) take a few of the stuff bits away.
      EXPECT_LE(stated, built + 4000) << extended << ' ' << bytes;
    }
}

TEST(Frame, FdFormulaIsNeverBelowARealFrame) {
  constexpr std::array<unsigned, 16> sizes = {0, 1,  2,  3,  4,  5,  6,  7,
                                              8, 12, 16, 20, 24, 32, 48, 64};
  for (const Timing timing : {Timing{.bitrate = 500'000, .data_bitrate = 2'000'000},
                              Timing{.bitrate = 1'000'000, .data_bitrate = 8'000'000},
                              Timing{.bitrate = 500'000, .data_bitrate = 500'000}})
    for (const bool extended : {false, true})
      for (unsigned code = 0; code < sizes.size(); ++code) {
        const Time slow = 1'000'000'000 / timing.bitrate;
        const Time fast = 1'000'000'000 / timing.data_bitrate;
        const Time built = built_fd(extended, code, sizes[code], slow, fast);
        const FrameForm form{.extended = extended, .fd = true};
        const Time stated = frame_time(timing, form, sizes[code]);
        EXPECT_GE(stated, built) << extended << ' ' << sizes[code];
        EXPECT_LE(stated, built + 5 * slow + 4 * fast) << extended << ' ' << sizes[code];
        if (code > 0) {  // what lies between two sizes takes the larger one
          EXPECT_EQ(stated, frame_time(timing, form, sizes[code - 1] + 1));
        }
      }
}

TEST(Frame, WithoutAChangeOfRateAllBitsOfAnFdFrameAreSlow) {
  const FrameForm fd{.extended = false, .fd = true};
  EXPECT_EQ(frame_time({.bitrate = 500'000, .data_bitrate = 0}, fd, 64),
            frame_time({.bitrate = 500'000, .data_bitrate = 500'000}, fd, 64));
}

/// docs/explanation/can-analysis.md: 35 or 59 slow bits, and 33 + 10 s or 38 + 10 s fast ones.
TEST(Frame, FdBitsTakeTheTimeOfTheirPhase) {
  const Timing timing{.bitrate = 500'000, .data_bitrate = 2'000'000};  // 2 us and 500 ns
  const FrameForm standard{.extended = false, .fd = true};
  const FrameForm extended{.extended = true, .fd = true};
  EXPECT_EQ(frame_time(timing, standard, 0), 35 * 2'000U + 33 * 500U);
  EXPECT_EQ(frame_time(timing, standard, 16), 35 * 2'000U + 193 * 500U);
  EXPECT_EQ(frame_time(timing, standard, 17), 35 * 2'000U + 238 * 500U) << "a longer CRC, 20 bytes";
  EXPECT_EQ(frame_time(timing, extended, 8), 59 * 2'000U + 113 * 500U);
  EXPECT_EQ(frame_time(timing, extended, 64), 59 * 2'000U + 678 * 500U);
  EXPECT_EQ(frame_time(timing, extended, 65), 59 * 2'000U + 678 * 500U) << "there are no more";
  // Each phase is rounded up for itself: 35 bits of 3000.003 ns, 33 bits of 499.99975 ns.
  EXPECT_EQ(frame_time({.bitrate = 333'333, .data_bitrate = 2'000'001}, standard, 0),
            105'001U + 16'500U);
}

TEST(Frame, ADataBitRateThatIsNoFasterIsNotChangedTo) {
  const FrameForm fd{.extended = false, .fd = true};
  for (const std::uint32_t data : {0U, 1U, 250'000U, 500'000U})
    EXPECT_EQ(frame_time({.bitrate = 500'000, .data_bitrate = data}, fd, 64), (35 + 678) * 2'000U)
        << data;
  EXPECT_EQ(frame_time({.bitrate = 500'000, .data_bitrate = 1'000'000}, fd, 64),
            35 * 2'000U + 678 * 1'000U);
}

/// 40 slow bits; 6 fast ones, and 109 + 8 s with a bit more for each ten.
TEST(Frame, XlBitsTakeTheTimeOfTheirPhase) {
  const Timing timing{.bitrate = 500'000, .data_bitrate = 10'000'000};  // 2 us and 100 ns
  EXPECT_EQ(xl_frame_time(timing, 1), 40 * 2'000U + (6 + 117 + 12) * 100U);
  EXPECT_EQ(xl_frame_time(timing, 0), xl_frame_time(timing, 1)) << "none is shorter";
  EXPECT_EQ(xl_frame_time(timing, 2), 40 * 2'000U + (6 + 125 + 13) * 100U);
  EXPECT_EQ(xl_frame_time(timing, 2048), 40 * 2'000U + (6 + 16'493 + 1'650) * 100U);
  EXPECT_EQ(xl_frame_time(timing, 2049), xl_frame_time(timing, 2048)) << "there are no more";
  EXPECT_EQ(xl_frame_time({.bitrate = 500'000}, 1), (40 + 6 + 117 + 12) * 2'000U);
  EXPECT_EQ(xl_frame_time({}, 1), kNever);
}

TEST(Frame, TheLongestFrameIsThatOfTheFormsThatABusCarries) {
  const Timing equal{.bitrate = 500'000, .data_bitrate = 500'000};
  EXPECT_EQ(longest_frame(equal, false), 160 * 2'000U);
  EXPECT_EQ(longest_frame(equal, true), (59 + 678) * 2'000U);
  EXPECT_EQ(longest_frame(equal, true, true), xl_frame_time(equal, 2048));
  // 59 slow bits and few fast ones are less than the 160 of a classic frame.
  const Timing fast{.bitrate = 125'000, .data_bitrate = 16'000'000};
  EXPECT_EQ(longest_frame(fast, true), 160 * 8'000U);
  // 18149 fast bits and 40 slow ones against 59 slow ones and 678 fast ones.
  const Timing fastest{.bitrate = 10'000, .data_bitrate = 400'000'000};
  EXPECT_EQ(longest_frame(fastest, false, true), 160 * 100'000U);
}

TEST(Frame, PhysicalLimitsAtOneMegabit) {
  const Timing timing{.bitrate = 1'000'000};
  EXPECT_EQ(frame_time(timing, {.extended = false}, 0), 55'000U);
  EXPECT_EQ(frame_time(timing, {.extended = false}, 8), 135'000U);
  EXPECT_EQ(frame_time(timing, {.extended = true}, 0), 80'000U);
  EXPECT_EQ(frame_time(timing, {.extended = true}, 8), 160'000U);
  EXPECT_EQ(longest_frame(timing, false), 160'000U);
  EXPECT_EQ(frame_time(timing, {}, 9), 135'000U);  // a classic frame has no more than 8
}

TEST(Frame, TimesAreRoundedUp) {
  EXPECT_EQ(bit_time({.bitrate = 83'333}), 12'001U);            // 12000.048 ns
  EXPECT_EQ(frame_time({.bitrate = 83'333}, {}, 0), 660'003U);  // 55 bits: 660002.64 ns
}

TEST(Frame, NothingIsKnownWithoutABitRate) {
  EXPECT_EQ(frame_time({}, {}, 8), kNever);
  EXPECT_EQ(longest_frame({}, true), kNever);
  EXPECT_EQ(bit_time({}), kNever);
}

TEST(Frame, ArbitrationIsWonAsOnTheBus) {
  EXPECT_LT(arbitration(0x100, false), arbitration(0x101, false));
  EXPECT_LT(arbitration(0x100, false), arbitration(0x100U << 18U, true));
  EXPECT_LT(arbitration(0x100U << 18U | 0x3ffff, true), arbitration(0x101, false));
  EXPECT_LT(arbitration(0x100U << 18U | 1, true), arbitration(0x100U << 18U | 2, true));
  EXPECT_LT(arbitration(0x7ff, false), arbitration(0x1fffffff, true));
}

}  // namespace
}  // namespace mlcca::core::can
