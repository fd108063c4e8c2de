// SPDX-License-Identifier: BSD-2-Clause
// Transfers of Cyphal/CAN: frames as the specification has them, and what no sender should send.
#include "relay/cyphal.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <string>

namespace mlcca::relay::cyphal {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;

Event counting(std::size_t size) {
  Event out(size);
  std::iota(out.begin(), out.end(), std::uint8_t{0});
  return out;
}

std::vector<Event> frames(std::size_t size, std::uint8_t number = 0, std::size_t octets = 8) {
  return frames_of(counting(size), octets, number).value();
}

std::string hex(const std::vector<Event>& frames) {
  static constexpr const char* digits = "0123456789abcdef";
  std::string out;
  for (const Event& frame : frames) {
    for (const std::uint8_t octet : frame) {
      out += digits[octet >> 4U];
      out += digits[octet & 0xfU];
    }
    out += ' ';
  }
  return out;
}

class CyphalTest : public ::testing::Test {
 protected:
  /// The events that these frames complete.
  std::vector<Event> take(const std::vector<Event>& frames, Reassembly::Source source = 1) {
    std::vector<Event> out;
    for (const Event& frame : frames)
      if (auto event = transfers_.take(source, frame, now_)) out.push_back(std::move(*event));
    return out;
  }
  std::uint64_t now_ = kSecond;
  Reassembly transfers_;
};

TEST_F(CyphalTest, TheChecksumIsThatOfTheSpecification) {
  const std::string text = "123456789";
  EXPECT_EQ(crc(Event(text.begin(), text.end())), 0x29b1);
}

TEST_F(CyphalTest, FramesAreThoseOfTheSpecification) {
  EXPECT_EQ(hex(frames(0)), "e0 ");
  EXPECT_EQ(hex(frames(7, 5)), "00010203040506e5 ");
  EXPECT_EQ(hex(frames(8, 5)), "00010203040506a5 07178d45 ");
  EXPECT_EQ(hex(frames(9)), "00010203040506a0 07086ede40 ") << "as the header of cyphal.hpp says";
  // The checksum itself may be cut.
  EXPECT_EQ(frames(12).size(), 2U);
  EXPECT_EQ(frames(13).size(), 3U);
  EXPECT_EQ(frames(13)[2].size(), 2U);
  // Of the first frame, the second one and the last one.
  const auto three = frames(15, 31);
  ASSERT_EQ(three.size(), 3U);
  EXPECT_EQ(three[0].back(), 0xbf);
  EXPECT_EQ(three[1].back(), 0x1f);
  EXPECT_EQ(three[2].back(), 0x7f);
}

TEST_F(CyphalTest, OnFdFramesHaveLengthsThatThereAre) {
  EXPECT_EQ(frames(8, 0, 64)[0].size(), 12U);
  EXPECT_EQ(frames(63, 0, 64)[0].size(), 64U);
  const auto two = frames(70, 0, 64);
  ASSERT_EQ(two.size(), 2U);
  EXPECT_EQ(two[0].size(), 64U);
  EXPECT_EQ(two[1].size(), 12U) << "7 octets, 2 of padding, the checksum and the tail";
  const auto got = take(two);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].size(), 72U) << "what the padding is, only the event's type says";
}

TEST_F(CyphalTest, EventsOfAnyLengthComeBack) {
  for (std::size_t size = 0; size < 300; ++size) {
    const auto got = take(frames(size, static_cast<std::uint8_t>(size)));
    ASSERT_EQ(got.size(), 1U) << size;
    EXPECT_EQ(got[0], counting(size));
  }
  EXPECT_EQ(transfers_.losses(), Losses{});
  EXPECT_EQ(transfers_.octets(), 0U);
}

TEST_F(CyphalTest, ItHasAtMost4096Frames) {
  EXPECT_EQ(frames(4096 * 7 - 2).size(), 4096U);
  EXPECT_FALSE(frames_of(counting(4096 * 7 - 1), 8, 0));
}

TEST_F(CyphalTest, FramesThatAreShorterThanOneOfCanCarryAnEventEach) {
  EXPECT_EQ(hex(frames_of(counting(2), 3, 0).value()), "0001e0 ");
  EXPECT_FALSE(frames_of(counting(3), 3, 0));
  EXPECT_TRUE(frames_of({}, 1, 0));
  EXPECT_FALSE(frames_of(counting(1), 1, 0));
  EXPECT_FALSE(frames_of({}, 0, 0));
}

TEST_F(CyphalTest, AFrameThatIsRepeatedIsTakenOnce) {
  auto four = frames(22, 3);
  ASSERT_EQ(four.size(), 4U);
  EXPECT_EQ(take({four[0], four[0], four[1], four[1], four[2], four[2], four[3], four[3]}).size(),
            1U);
  EXPECT_EQ(take(four).size(), 0U) << "the whole transfer once more";
  EXPECT_EQ(transfers_.losses().incomplete, 0U);
  EXPECT_EQ(take(frames(5, 3)).size(), 0U) << "a transfer of one frame, too";
  EXPECT_EQ(transfers_.losses().duplicates, 3U);
  now_ += 2 * kSecond + 1;
  EXPECT_EQ(take(four).size(), 1U) << "so late it is another one: there are 32 numbers";
}

TEST_F(CyphalTest, WhereAFrameIsMissingNothingComes) {
  const auto whole = frames(36, 1);
  ASSERT_EQ(whole.size(), 6U);
  for (std::size_t missing = 0; missing < whole.size(); ++missing) {
    auto some = whole;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(missing));
    EXPECT_EQ(take(some).size(), 0U) << missing;
  }
  EXPECT_EQ(take(frames(36, 2)).size(), 1U);
  EXPECT_EQ(transfers_.losses().incomplete, 6U);
  EXPECT_EQ(transfers_.losses().malformed, 0U);
}

TEST_F(CyphalTest, ATransferThatStopsIsGivenUpAfterTwoSeconds) {
  const auto two = frames(10, 1);
  EXPECT_EQ(take({two[0]}).size(), 0U);
  now_ += 2 * kSecond + 1;
  EXPECT_EQ(take({two[1]}).size(), 0U);
  EXPECT_EQ(transfers_.octets(), 0U);
}

TEST_F(CyphalTest, ATransferThatNothingFollowsIsGivenUpOnTime) {
  const auto two = frames(10, 1);
  take({two[0]});
  transfers_.expire(now_ + 2 * kSecond);
  EXPECT_NE(transfers_.octets(), 0U);
  transfers_.expire(now_ + 2 * kSecond + 1);
  EXPECT_EQ(transfers_.octets(), 0U);
  EXPECT_EQ(transfers_.losses().incomplete, 1U);
}

TEST_F(CyphalTest, PublishersAreApart) {
  const auto a = frames(20, 1);
  const auto b = frames(20, 1);
  std::size_t complete = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    complete += take({a[i]}, 1).size() + take({b[i]}, 2).size();
  EXPECT_EQ(complete, 2U);
}

TEST_F(CyphalTest, WhatIsNoFrameOfCyphalIsCounted) {
  EXPECT_EQ(take({{}, {1, 2, 0xc0}, {1, 2, 0xa0}, {1, 2, 0x00}}).size(), 0U)
      << "empty, of UAVCAN 0, not full, not full";
  EXPECT_EQ(transfers_.losses().malformed, 4U);
  EXPECT_EQ(transfers_.sources(), 0U);
}

TEST_F(CyphalTest, MemoryIsBounded) {
  transfers_ = Reassembly({.sources = 4, .octets = 100, .lifetime_ns = kSecond});
  for (Reassembly::Source source = 0; source < 100; ++source) {
    ++now_;
    take({frames(50, 1)[0]}, source);
    EXPECT_LE(transfers_.sources(), 4U);
  }
  EXPECT_EQ(transfers_.losses().crowded, 96U);
  // One source alone, longer than all may be: its own transfer is given up.
  EXPECT_EQ(take(frames(200, 2), 99).size(), 0U);
  EXPECT_LE(transfers_.octets(), 100U);
  EXPECT_EQ(take(frames(20, 3), 99).size(), 1U);
}

TEST_F(CyphalTest, NothingWrongComesOfRandomFrames) {
  std::mt19937 random(1);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  transfers_ = Reassembly({.sources = 8, .octets = 500, .lifetime_ns = 1000});
  std::size_t complete = 0;
  for (int round = 0; round < 20'000; ++round) {
    now_ += below(100);
    for (Event& frame : frames(below(40), static_cast<std::uint8_t>(below(32)))) {
      const auto fate = below(10);
      if (fate == 0) continue;  // lost
      if (fate == 1) frame[below(static_cast<std::uint32_t>(frame.size()))] ^= 0x10;
      if (const auto event = transfers_.take(below(12), frame, now_)) {
        ++complete;
        EXPECT_LE(event->size(), 500U);
      }
    }
    ASSERT_LE(transfers_.octets(), 500U);
    ASSERT_LE(transfers_.sources(), 8U);
  }
  EXPECT_GT(complete, 0U);
}

}  // namespace
}  // namespace mlcca::relay::cyphal
