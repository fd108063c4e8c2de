// SPDX-License-Identifier: BSD-2-Clause
// The Ethernet gate keeps which stations send in place of the granted ones: the latest ones, in a
// table of fixed size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "daemon/gates/counters.hpp"
#include "tests/bpf/ether/events.hpp"

namespace mlcca::test {
namespace {

using gates::RefusedSender;

constexpr std::uint64_t kGranted = 0x0a000001;

class EtherSenders : public ::testing::Test {
 protected:
  void SetUp() override { gate_.admit({granted_}); }
  static Bytes from_station(std::uint32_t station, std::uint16_t bytes = 8) {
    return packet([=](Datagram& d) {
      d.source = station;
      d.payload = bytes;
    });
  }
  [[nodiscard]] std::vector<RefusedSender> senders() const {
    return gates::refused_senders(gate_.cpus());
  }

  const SlotSpec granted_ = with(in(), [](SlotSpec& s) { s.station = kGranted; });
  LoadedEther& gate_ = LoadedEther::with();
};

TEST_F(EtherSenders, AStationThatSendsForAnotherIsCountedWithItsAddresses) {
  for (int i = 0; i < 3; ++i) gate_.run(kIn, from_station(0x0a000002, 7));
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].frame.subject, kSubject);
  EXPECT_EQ(found[0].frame.station, 0x0a000002U);
  EXPECT_NE(found[0].frame.mac, gates::Mac{});
  EXPECT_EQ(found[0].frame.count, 3U);
  EXPECT_EQ(found[0].frame.len, 7U);
  EXPECT_EQ(found[0].reason, core::FrameReason::source);
  EXPECT_EQ(found[0].slot, gate_.table().find(granted_));
}

TEST_F(EtherSenders, TheDriverCountsThemAsWell) {
  EXPECT_TRUE(gate_.dropped_early(from_station(0x0a000002)));
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].frame.station, 0x0a000002U);
  EXPECT_NE(found[0].frame.mac, gates::Mac{});
}

TEST_F(EtherSenders, AMalformedDatagramIsCountedWithItsStationAndTheSubjectThatItNames) {
  const Bytes bytes = packet([](Datagram& d) { d.flag = 2; });
  gate_.run(kIn, bytes);
  EXPECT_TRUE(gate_.dropped_early(bytes));
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].reason, core::FrameReason::malformed);
  EXPECT_TRUE(found[0].is_without_slot());
  EXPECT_EQ(found[0].frame.subject, kSubject);
  EXPECT_EQ(found[0].frame.station, kGranted);
  EXPECT_NE(found[0].frame.mac, gates::Mac{});
  EXPECT_EQ(found[0].frame.count, 2U);
  EXPECT_EQ(found[0].frame.len, bytes.size());
}

TEST_F(EtherSenders, ADatagramThatEndsBeforeItsSubjectHasTheStationOnly) {
  constexpr std::size_t headers = 14 + 20 + 8;
  Bytes bytes = packet();
  bytes.resize(headers + 4);
  bytes[17] = 20 + 8 + 4;  // length of the IP packet
  bytes[39] = 8 + 4;       // of the datagram
  gate_.run(kIn, bytes);
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].reason, core::FrameReason::malformed);
  EXPECT_EQ(found[0].frame.subject, 0U);
  EXPECT_EQ(found[0].frame.station, kGranted);
}

TEST_F(EtherSenders, ALaterPartOfNoMessageHasItsStation) {
  Datagram d;
  d.subject = kSubject;
  d.payload = 64;
  gate_.run(kIn, frame(d.fragment(32, 64)));
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].reason, core::FrameReason::fragment);
  EXPECT_EQ(found[0].frame.station, kGranted);
  EXPECT_EQ(found[0].frame.subject, 0U);
}

TEST_F(EtherSenders, AuditModeCountsThemToo) {
  gate_.control().mode = GATE_AUDIT;
  EXPECT_FALSE(gate_.run(kIn, from_station(0x0a000002)).dropped);
  ASSERT_EQ(senders().size(), 1U);
}

TEST_F(EtherSenders, WhatPassesAndWhatHasNoSlotIsNotCounted) {
  gate_.run(kIn, packet());
  gate_.run(kIn, packet([](Datagram& d) { d.subject = kSubject + 1; }));
  gate_.run(kIn, from_station(kGranted, 200));
  EXPECT_TRUE(senders().empty());
}

TEST_F(EtherSenders, AProgramIsCountedWithItsUserAndALinkWithItsInterface) {
  gate_.reset();
  gate_.admit({of_user(1000)});
  gate_.run(kOut, packet(), kLocal);
  gate_.run(kOut, packet(), kForwarded);
  auto found = senders();
  std::ranges::sort(found, {}, &RefusedSender::source);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].source, 0U);
  EXPECT_EQ(found[0].uid, 0U);
  EXPECT_EQ(found[1].source, kOther);
  EXPECT_EQ(found[1].uid, GATE_ANY_UID);
  EXPECT_EQ(found[1].frame.direction, kOut);
}

/// Test runs stay on one CPU, so that its table is the whole one.
TEST_F(EtherSenders, WhoHasBeenQuietForLongestGivesWay) {
  constexpr std::uint32_t steady = 0x0a000002;
  constexpr std::uint32_t many = 4 * GATE_SENDERS;
  gate_.run(kIn, from_station(steady));
  for (std::uint32_t i = 0; i < many; ++i) {
    gate_.run(kIn, from_station(0x0b000000 + i * 7919));
    gate_.run(kIn, from_station(steady));
  }
  const auto found = senders();
  EXPECT_LE(found.size(), GATE_SENDERS * gate_.cpus().size());
  EXPECT_GE(found.size(), GATE_SENDERS) << "all places are used";
  EXPECT_EQ(gate_.reasons(kIn).at(GATE_R_SOURCE), 2 * many + 1) << "all frames are counted";
  EXPECT_TRUE(std::ranges::any_of(found, [&](const RefusedSender& sender) {
    return sender.frame.station == steady && sender.frame.count == many + 1;
  })) << "who goes on sending stays";
}

}  // namespace
}  // namespace mlcca::test
