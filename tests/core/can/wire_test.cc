// SPDX-License-Identifier: BSD-2-Clause
// Frames are written bit by bit, with the CRC by long division, and stuffed.
#include "core/can/wire.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>

namespace mlcca::core::can {
namespace {

std::string binary(std::uint32_t value, unsigned width) {
  std::string bits;
  for (unsigned i = width; i-- > 0;) bits += (value >> i & 1U) != 0 ? '1' : '0';
  return bits;
}

/// Remainder of the bits, with 15 zeros behind them, divided by x^15+x^14+x^10+x^8+x^7+x^4+x^3+1.
std::string remainder(std::string bits) {
  const std::string divisor = "1100010110011001";
  bits.append(15, '0');
  for (std::size_t at = 0; at + divisor.size() <= bits.size(); ++at)
    if (bits[at] == '1')
      for (std::size_t i = 0; i < divisor.size(); ++i)
        bits[at + i] = bits[at + i] == divisor[i] ? '0' : '1';
  return bits.substr(bits.size() - 15);
}

/// `at_end`: whether the last bit may be followed by a stuff bit.
std::string stuffed(const std::string& bits, bool at_end = true) {
  std::string out;
  unsigned run = 0;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const char bit = bits[i];
    run = !out.empty() && out.back() == bit ? run + 1 : 1;
    out += bit;
    if (run == 5 && (at_end || i + 1 < bits.size())) {
      out += bit == '0' ? '1' : '0';
      run = 1;
    }
  }
  return out;
}

std::string head(const WireFrame& f) {
  const std::string request = f.remote ? "1" : "0";
  if (!f.extended) return "0" + binary(f.id, 11) + request + "0";
  return "0" + binary(f.id >> 18U, 11) + "11" + binary(f.id & 0x3ffff, 18) + request;
}

std::string payload(const WireFrame& f) {
  std::string bits;
  for (unsigned i = 0; i < f.size && !f.remote; ++i) bits += binary(f.data[i], 8);
  return bits;
}

unsigned written(const WireFrame& f) {
  const std::string bits = head(f) + (f.extended ? "00" : "0") + binary(f.size, 4) + payload(f);
  return static_cast<unsigned>(stuffed(bits + remainder(bits)).size()) + 13;
}

WireFrame any_frame(std::mt19937& random) {
  WireFrame f;
  f.extended = random() % 2 != 0;
  f.id = static_cast<std::uint32_t>(random()) & (f.extended ? 0x1fffffffU : 0x7ffU);
  f.remote = random() % 8 == 0;
  f.size = static_cast<std::uint8_t>(random() % 9);
  // Long runs are what stuffing is about.
  for (auto& byte : f.data) {
    const auto kind = random() % 3;
    byte = kind == 0 ? 0 : kind == 1 ? 0xff : static_cast<std::uint8_t>(random());
  }
  return f;
}

TEST(Wire, AClassicFrameHasTheBitsThatAreWritten) {
  std::mt19937 random(1);
  for (unsigned i = 0; i < 20'000; ++i) {
    const auto f = any_frame(random);
    EXPECT_EQ(wire_length(f), (WireLength{.slow = written(f), .fast = 0}));
  }
}

/// The four bits that state the length of an FD frame.
std::string fd_length(unsigned bytes) {
  const std::map<unsigned, std::string> longer = {{12, "1001"}, {16, "1010"}, {20, "1011"},
                                                  {24, "1100"}, {32, "1101"}, {48, "1110"},
                                                  {64, "1111"}};
  return bytes <= 8 ? binary(bytes, 4) : longer.lower_bound(bytes)->second;
}

/// Dynamic stuffing ends with the payload. What follows has a length of its own: stuff count and
/// CRC with their fixed stuff bits, delimiter; acknowledgement to intermission.
WireLength written_fd(const WireFrame& f) {
  const std::string first = head(f) + "10" + (f.switches ? "1" : "0");
  WireFrame padded = f;  // to a size that exists; what is added is zero
  while (padded.size > 8 && padded.size != 12 && padded.size != 16 && padded.size != 20 &&
         padded.size != 24 && padded.size != 32 && padded.size != 48 && padded.size != 64)
    padded.data[padded.size++] = 0;
  const std::string second = (f.passive ? "1" : "0") + fd_length(f.size) + payload(padded);
  const std::string all = stuffed(first + second, false);
  const auto slow = static_cast<unsigned>(stuffed(first).size());
  const unsigned fast = static_cast<unsigned>(all.size()) - slow + (padded.size > 16 ? 32 : 27) + 1;
  if (f.switches) return {.slow = slow + 12, .fast = fast};
  return {.slow = slow + fast + 12, .fast = 0};
}

TEST(Wire, AnFdFrameHasTheBitsThatAreWritten) {
  std::mt19937 random(3);
  for (unsigned i = 0; i < 20'000; ++i) {
    auto f = any_frame(random);
    f.fd = true;
    f.remote = false;
    f.switches = random() % 2 != 0;
    f.passive = random() % 2 != 0;
    f.size = static_cast<std::uint8_t>(random() % 65);
    for (std::size_t at = f.size; at < f.data.size(); ++at) f.data[at] = 0;
    ASSERT_EQ(wire_length(f), written_fd(f)) << i << ", " << unsigned{f.size} << " bytes";
  }
}

TEST(Wire, NoFrameIsLongerThanTheBoundOfItsForm) {
  const Timing timing{.bitrate = 1'000'000, .data_bitrate = 8'000'000};
  std::mt19937 random(2);
  for (unsigned i = 0; i < 20'000; ++i) {
    auto f = any_frame(random);
    f.fd = f.switches = i % 2 != 0;
    if (f.fd) f.size = static_cast<std::uint8_t>(random() % 65);
    f.remote = false;
    EXPECT_LE(wire_time(timing, wire_length(f)),
              frame_time(timing, {.extended = f.extended, .fd = f.fd}, f.size));
  }
}

// Counted by hand. The identifier changes at each bit, FDF, reserved and BRS too: no stuff bits but
// where the payload is all zero: 4 bits of its length 0001 end in a one, eight zeros take one.
TEST(Wire, AnFdFrameChangesItsRateBehindBrs) {
  WireFrame f{.id = 0x555, .fd = true, .switches = true, .size = 1};
  // Slow: 17 to BRS, 1 acknowledgement, 1 delimiter, 7 end of frame, 3 intermission.
  // Fast: ESI, DLC, payload, one stuff bit, 27 with the CRC, its delimiter.
  EXPECT_EQ(wire_length(f), (WireLength{.slow = 17 + 12, .fast = 1 + 4 + 8 + 1 + 27 + 1}));
  f.switches = false;
  // Without a change of rate BRS is dominant: reserved, BRS, ESI and DLC are six zeros with their
  // stuff bit.
  EXPECT_EQ(wire_length(f), (WireLength{.slow = 17 + 12 + 1 + 4 + 8 + 1 + 27 + 1 + 1, .fast = 0}));
}

TEST(Wire, NoDynamicStuffBitStandsBeforeAFixedOne) {
  WireFrame f{.id = 0x555, .fd = true, .switches = true, .size = 1};
  f.data[0] = 0xe0;  // ends in five zeros
  EXPECT_EQ(wire_length(f).fast, 1U + 4 + 8 + 27 + 1);
  f.data[0] = 0x05;
  EXPECT_EQ(wire_length(f).fast, 1U + 4 + 8 + 1 + 27 + 1) << "0001 and then five zeros in a row";
}

TEST(Wire, BothPhasesTakeTheirTime) {
  EXPECT_EQ(wire_time({.bitrate = 500'000, .data_bitrate = 2'000'000}, {.slow = 10, .fast = 8}),
            24'000U);
  EXPECT_EQ(wire_time({.bitrate = 500'000}, {.slow = 10, .fast = 8}), 36'000U);
  EXPECT_EQ(wire_time({}, {.slow = 10}), kNever);
  // Rounded to the nearest nanosecond: 3 / 7 s and 2 / 7 s.
  EXPECT_EQ(wire_time({.bitrate = 7}, {.slow = 3}), 428'571'429U);
  EXPECT_EQ(wire_time({.bitrate = 7}, {.slow = 2}), 285'714'286U);
}

}  // namespace
}  // namespace mlcca::core::can
