// SPDX-License-Identifier: BSD-2-Clause
// Messages of J1939's transport protocol. The announcement is that of SAE J1939-21, 5.10.3.1, as
// the kernel's documentation of can-j1939 and can-utils show it.
#include "relay/j1939.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace mlcca::relay::j1939 {
namespace {

constexpr std::uint32_t kId = 0x18feca05;
constexpr std::uint32_t kBam = 0x18ecff05;
constexpr std::uint32_t kPacketId = 0x18ebff05;
constexpr std::uint64_t kSecond = 1'000'000'000;

Event counting(std::size_t size) {
  Event out(size);
  std::iota(out.begin(), out.end(), std::uint8_t{0});
  return out;
}

TEST(Frames, AnnounceTheMessageAndFillTheLastPacket) {
  const auto frames = frames_of(counting(20), kId);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0], (Data{0x20, 20, 0, 3, 0xff, 0xca, 0xfe, 0}));
  EXPECT_EQ(frames[1], (Data{1, 0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(frames[3], (Data{3, 14, 15, 16, 17, 18, 19, 0xff}));
}

TEST(Frames, NameTheDestinationOnlyInTheIdentifier) {
  EXPECT_EQ(frames_of(counting(9), 0x1912ff05)[0], (Data{0x20, 9, 0, 2, 0xff, 0, 0x12, 1}));
}

TEST(Frames, ThereAreForNineTo1785Octets) {
  EXPECT_TRUE(frames_of(counting(8), kId).empty());
  EXPECT_EQ(frames_of(counting(9), kId).size(), 3U);
  EXPECT_EQ(frames_of(counting(14), kId).size(), 3U);
  EXPECT_EQ(frames_of(counting(15), kId).size(), 4U);
  const auto longest = frames_of(counting(1785), kId);
  EXPECT_EQ(longest.size(), 256U);
  EXPECT_EQ(longest.back()[0], 255);
  EXPECT_EQ(longest.front()[3], 255);
  EXPECT_TRUE(frames_of(counting(1786), kId).empty());
}

TEST(Identifiers, OfWhatCarriesAMessageKeepPriorityAndSource) {
  EXPECT_EQ(announcement_of(kId), kBam);
  EXPECT_EQ(packet_of(kId), kPacketId);
  EXPECT_EQ(packet_of(0x8112ff05), 0x80ebff05U);
  EXPECT_TRUE(is_announcement(kBam));
  EXPECT_FALSE(is_announcement(0x18ec2105)) << "to one";
  EXPECT_FALSE(is_announcement(0x19ecff05)) << "another page";
  EXPECT_TRUE(is_packet(kPacketId));
  EXPECT_FALSE(is_packet(kBam));
}

class Messages : public ::testing::Test {
 protected:
  std::optional<Reassembly::Message> take(const std::vector<Data>& frames, std::size_t from = 0,
                                          std::uint32_t source = 5) {
    std::optional<Reassembly::Message> whole;
    for (std::size_t i = from; i < frames.size(); ++i) {
      now_ += kPause;
      if (i == 0)
        messages_.announce((kBam & ~kSource) | source, frames[0], true, now_);
      else
        whole = messages_.take((kPacketId & ~kSource) | source, frames[i], now_);
    }
    return whole;
  }
  bool takes(unsigned number) {
    Data data{};
    data[0] = static_cast<std::uint8_t>(number);
    return messages_.take(kPacketId, data, now_).has_value();
  }

  Reassembly messages_;
  std::uint64_t now_ = kSecond;
};

TEST_F(Messages, ArePutTogether) {
  for (const std::size_t size : {9U, 14U, 15U, 20U, 256U, 1784U, 1785U}) {
    const auto whole = take(frames_of(counting(size), kId));
    ASSERT_TRUE(whole) << size;
    EXPECT_EQ(whole->event, counting(size));
    EXPECT_EQ(whole->id, kId);
  }
  EXPECT_EQ(messages_.sessions(), 0U);
  EXPECT_EQ(messages_.losses(), Losses{});
}

TEST_F(Messages, OfSeveralSourcesMayBeUnderWay) {
  const auto frames = frames_of(counting(20), kId);
  for (std::uint32_t source = 0; source < 256; ++source)
    messages_.announce((kBam & ~kSource) | source, frames[0], true, now_);
  EXPECT_EQ(messages_.sessions(), 256U);
  for (std::size_t i = 1; i < frames.size(); ++i)
    for (std::uint32_t source = 0; source < 256; ++source) {
      const auto whole = messages_.take((kPacketId & ~kSource) | source, frames[i], now_);
      EXPECT_EQ(whole.has_value(), i == 3);
      if (whole) {
        EXPECT_EQ(whole->id, (kId & ~kSource) | source);
      }
    }
  EXPECT_EQ(messages_.sessions(), 0U);
}

TEST_F(Messages, OutOfOrderAreGivenUp) {
  const auto frames = frames_of(counting(20), kId);
  for (const unsigned wrong : {0U, 2U, 3U, 255U}) {
    messages_.announce(kBam, frames[0], true, now_);
    EXPECT_FALSE(takes(wrong));
    EXPECT_FALSE(take(frames, 1)) << wrong;
  }
  EXPECT_EQ(messages_.losses().incomplete, 4U);
  EXPECT_TRUE(take(frames));
}

TEST_F(Messages, TheNextAnnouncementEndsTheOneBefore) {
  const auto frames = frames_of(counting(20), kId);
  messages_.announce(kBam, frames[0], true, now_);
  messages_.announce(kBam, frames[0], true, now_);
  EXPECT_EQ(messages_.losses().incomplete, 1U);
  messages_.announce(kBam, frames[0], false, now_);
  EXPECT_EQ(messages_.losses().incomplete, 2U);
  EXPECT_FALSE(take(frames, 1)) << "nobody wants what was announced";
  EXPECT_EQ(messages_.losses().incomplete, 2U);
}

TEST_F(Messages, ThatPauseTooLongAreGivenUp) {
  const auto frames = frames_of(counting(9), kId);
  messages_.announce(kBam, frames[0], true, now_);
  EXPECT_FALSE(messages_.take(kPacketId, frames[1], now_ + kTimeout));
  EXPECT_FALSE(messages_.take(kPacketId, frames[2], now_ + 2 * kTimeout + 1));
  EXPECT_EQ(messages_.losses().incomplete, 1U);
}

TEST_F(Messages, ThatNothingFollowsAreGivenUpOnTime) {
  messages_.announce(kBam, frames_of(counting(9), kId)[0], true, now_);
  messages_.expire(now_ + kTimeout);
  EXPECT_EQ(messages_.sessions(), 1U);
  messages_.expire(now_ + kTimeout + 1);
  EXPECT_EQ(messages_.sessions(), 0U);
  EXPECT_EQ(messages_.losses().incomplete, 1U);
}

TEST_F(Messages, ThatContradictThemselvesAreNone) {
  for (const Data& bad :
       {Data{0x20, 8, 0, 2, 0xff, 0xca, 0xfe, 0}, Data{0x20, 20, 0, 4, 0xff, 0xca, 0xfe, 0},
        Data{0x20, 0xfa, 6, 255, 0xff, 0xca, 0xfe, 0}})
    messages_.announce(kBam, bad, true, now_);
  EXPECT_EQ(messages_.losses().malformed, 3U);
  messages_.announce(kBam, Data{0x10, 20, 0, 3, 0xff, 0xca, 0xfe, 0}, true, now_);
  messages_.announce(kBam, Data{0x20, 20, 0, 3, 0xff, 0xca, 0xfe, 4}, true, now_);
  messages_.announce(kBam, Octets(), true, now_);
  EXPECT_EQ(messages_.sessions(), 0U);
  EXPECT_FALSE(takes(1));
}

// --- what is sent --------------------------------------------------------------------------------

class ToSend : public ::testing::Test {
 protected:
  struct Frame {
    std::uint32_t id;
    Data data;
  };
  bool add(std::size_t size, std::uint32_t source = 5) {
    return sending_.add({.announcement = (kBam & ~kSource) | source,
                         .packet = (kPacketId & ~kSource) | source,
                         .frames = frames_of(counting(size), kId)});
  }
  std::size_t run() {
    const std::size_t before = out_.size();
    const auto clock = [this] { return now_; };
    sending_.run(clock, [&](std::uint32_t id, const Data& data) {
      out_.push_back({id, data});
      now_ += sending_takes_;
      return takes_;
    });
    return out_.size() - before;
  }

  Sending sending_;
  std::vector<Frame> out_;
  std::uint64_t now_ = kSecond;
  std::uint64_t sending_takes_ = 0;
  bool takes_ = true;
};

TEST_F(ToSend, ThePauseBeginsWhenAFrameHasBeenSent) {
  ASSERT_TRUE(add(9));
  sending_takes_ = kPause / 2;
  EXPECT_EQ(run(), 1U);
  EXPECT_EQ(*sending_.due(), now_ + kPause);
}

TEST_F(ToSend, OneFrameOfASourceGoesInEachPause) {
  EXPECT_FALSE(sending_.due());
  ASSERT_TRUE(add(9));
  ASSERT_TRUE(add(9));
  std::vector<std::uint32_t> ids;
  for (int i = 0; i < 6; ++i) {
    EXPECT_LE(*sending_.due(), now_);
    EXPECT_EQ(run(), 1U);
    EXPECT_EQ(run(), 0U) << "too soon";
    if (i < 5) {
      EXPECT_EQ(*sending_.due(), now_ + kPause);
    }
    now_ += kPause;
  }
  EXPECT_FALSE(sending_.due());
  for (const Frame& frame : out_) ids.push_back(frame.id);
  EXPECT_EQ(ids,
            (std::vector<std::uint32_t>{kBam, kPacketId, kPacketId, kBam, kPacketId, kPacketId}));
  ASSERT_TRUE(add(9));
  now_ -= kPause / 2;
  EXPECT_EQ(run(), 0U) << "the pause is between messages too";
}

TEST_F(ToSend, SourcesDoNotWaitForEachOther) {
  ASSERT_TRUE(add(20, 5));
  ASSERT_TRUE(add(9, 6));
  EXPECT_EQ(run(), 2U);
}

TEST_F(ToSend, WhatComesLateIsNotMadeUpFor) {
  ASSERT_TRUE(add(20));
  EXPECT_EQ(run(), 1U);
  now_ += 10 * kPause;
  EXPECT_EQ(run(), 1U);
  EXPECT_EQ(*sending_.due(), now_ + kPause);
}

TEST_F(ToSend, SoManyWait) {
  for (std::size_t i = 0; i < Sending::kMostWaiting; ++i) EXPECT_TRUE(add(9));
  EXPECT_FALSE(add(9));
  EXPECT_TRUE(add(9, 6));
  EXPECT_FALSE(sending_.add({}));
}

TEST_F(ToSend, AMessageThatIsNotTakenIsGivenUp) {
  ASSERT_TRUE(add(20));
  ASSERT_TRUE(add(9));
  EXPECT_EQ(run(), 1U);
  now_ += kPause;
  takes_ = false;
  EXPECT_EQ(run(), 1U);
  now_ += kPause;
  takes_ = true;
  EXPECT_EQ(run(), 1U);
  EXPECT_EQ(out_.back().id, kBam);
  EXPECT_EQ(out_.back().data[1], 9);
}

}  // namespace
}  // namespace mlcca::relay::j1939
