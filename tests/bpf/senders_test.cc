// SPDX-License-Identifier: BSD-2-Clause
// The gate keeps who sends in place of the granted sender: the latest ones, in a table of fixed
// size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "daemon/gates/counters.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::RefusedSender;
using gates::SlotSpec;

constexpr std::uint32_t kEff = CAN_EFF_FLAG;
constexpr std::uint32_t kForm = CAN_EFF_FLAG | CAN_RTR_FLAG;

/// A frame of a FAMOUSO node; node 5 is granted.
constexpr std::uint32_t of_node(std::uint32_t node, std::uint32_t priority = 0x7d) {
  return kEff | priority << 22U | node << 14U | 0x64U;
}

class GateSenders : public ::testing::Test {
 protected:
  static SlotSpec slot(Direction direction, std::uint32_t id) {
    SlotSpec s;
    s.direction = direction;
    s.pass = true;
    s.id = id;
    s.mask = kForm | CAN_EFF_MASK;
    s.subject = 1;
    return s;
  }
  void SetUp() override { gate_.admit({in_, out_}); }
  void receive(std::uint32_t id, unsigned length = 8) {
    gate_.run(Direction::ingress, frame(id, length));
  }
  [[nodiscard]] std::vector<RefusedSender> senders() const {
    return gates::refused_senders(gate_.cpus());
  }
  [[nodiscard]] std::uint64_t refused(gate_reason reason) const {
    return gates::reason_counters(gate_.cpus(), Direction::ingress).at(reason);
  }

  const SlotSpec in_ = slot(Direction::ingress, of_node(5));
  const SlotSpec out_ = slot(Direction::egress, of_node(5));
  LoadedGate& gate_ = LoadedGate::with({.profile = GATE_PROFILE_FAMOUSO});
};

TEST_F(GateSenders, ANodeThatSendsForAnotherIsCountedWithItsIdentifier) {
  for (int i = 0; i < 3; ++i) receive(of_node(33), 7);
  receive(of_node(34));
  const auto found = senders();
  ASSERT_EQ(found.size(), 2U);
  const RefusedSender& first = found[0].frame.can_id == of_node(33) ? found[0] : found[1];
  EXPECT_EQ(first.frame.can_id, of_node(33));
  EXPECT_EQ(first.frame.count, 3U);
  EXPECT_EQ(first.frame.len, 7U);
  EXPECT_EQ(first.frame.format, GATE_CLASSIC);
  EXPECT_EQ(first.frame.direction, Direction::ingress);
  EXPECT_EQ(first.reason, core::FrameReason::identifier);
  EXPECT_EQ(first.slot, gate_.slots().find(in_));
}

TEST_F(GateSenders, WhatPassesAndWhatHasNoSlotIsNotCounted) {
  receive(of_node(5));
  receive(kEff | 0x65U);
  gate_.control().lapsed = 1;
  receive(of_node(5));
  receive(of_node(33));
  EXPECT_TRUE(senders().empty());
}

TEST_F(GateSenders, AMalformedFrameIsCountedWithItsIdentifierAndTheUserWhoSendsIt) {
  gate_.run(Direction::egress, frame(of_node(5), 9), {.local = true});
  gate_.run(Direction::egress, frame(of_node(5), 9), {.local = true});
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].reason, core::FrameReason::malformed);
  EXPECT_TRUE(found[0].is_without_slot());
  EXPECT_EQ(found[0].frame.can_id, of_node(5));
  EXPECT_EQ(found[0].frame.format, GATE_CLASSIC);
  EXPECT_EQ(found[0].frame.direction, Direction::egress);
  EXPECT_EQ(found[0].frame.count, 2U);
  EXPECT_EQ(found[0].frame.len, CAN_MTU);
  EXPECT_EQ(found[0].source, 0U);
  EXPECT_EQ(found[0].uid, 0U);
}

/// On its way out nothing precedes a frame, so that the first word is its identifier.
TEST_F(GateSenders, OfAFrameThatIsTooShortTheIdentifierIsReadWhereItIsKnownToBe) {
  const Bytes shortest = {0x23, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  gate_.run(Direction::egress, shortest, {.ingress_ifindex = kOther, .xl = true});
  gate_.run(Direction::ingress, shortest, {.xl = true});
  auto found = senders();
  ASSERT_EQ(found.size(), 2U);
  std::ranges::sort(found, {}, &RefusedSender::slot);
  EXPECT_EQ(found[0].frame.direction, Direction::ingress);
  EXPECT_EQ(found[0].frame.can_id, 0U);
  EXPECT_EQ(found[0].frame.format, 0U) << "it is not known";
  EXPECT_EQ(found[1].frame.direction, Direction::egress);
  EXPECT_EQ(found[1].frame.can_id, 0x123U);
  EXPECT_EQ(found[1].frame.format, GATE_XL);
  EXPECT_EQ(found[1].source, kOther);
  for (const RefusedSender& sender : found) {
    EXPECT_EQ(sender.reason, core::FrameReason::malformed);
    EXPECT_EQ(sender.frame.len, shortest.size());
  }
}

TEST_F(GateSenders, AnErrorFrameOnItsWayOutIsCountedWithTheUserWhoSendsIt) {
  gate_.run(Direction::egress, frame(CAN_ERR_FLAG | 4, 8), {.local = true});
  const auto found = senders();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].reason, core::FrameReason::error_frame);
  EXPECT_EQ(found[0].uid, 0U);
}

TEST_F(GateSenders, AuditModeCountsThemToo) {
  gate_.control().mode = GATE_AUDIT;
  receive(of_node(33));
  ASSERT_EQ(senders().size(), 1U);
  EXPECT_EQ(senders()[0].frame.count, 1U);
}

TEST_F(GateSenders, AProgramIsCountedWithItsUserAndABusWithItsInterface) {
  SlotSpec of_another = out_;
  of_another.uid = 1000;
  gate_.reset();
  gate_.admit({of_another});
  const Bytes sent = frame(of_node(5), 8);
  gate_.run(Direction::egress, sent, {.local = true});
  gate_.run(Direction::egress, sent, {.ingress_ifindex = kOther});
  auto found = senders();
  std::ranges::sort(found, {}, &RefusedSender::source);
  ASSERT_EQ(found.size(), 2U);
  for (const RefusedSender& sender : found) {
    EXPECT_EQ(sender.reason, core::FrameReason::source);
    EXPECT_EQ(sender.frame.direction, Direction::egress);
  }
  EXPECT_EQ(found[0].source, 0U);
  EXPECT_EQ(found[0].uid, 0U);
  EXPECT_EQ(found[1].source, kOther);
  EXPECT_EQ(found[1].uid, GATE_ANY_UID);
}

/// Test runs stay on one CPU, so that its table is the whole one.
TEST_F(GateSenders, WhoHasBeenQuietForLongestGivesWay) {
  receive(of_node(127));
  std::vector<std::uint32_t> ids;
  for (std::uint32_t node = 6; node < 127; ++node)
    for (const std::uint32_t priority : {0x7dU, 0x10U, 0x11U})
      ids.push_back(of_node(node, priority));
  ASSERT_GT(ids.size(), 3U * GATE_SENDERS);
  for (const std::uint32_t id : ids) {
    receive(id);
    receive(of_node(127));  // of the latest
  }
  const auto found = senders();
  EXPECT_LE(found.size(), GATE_SENDERS * gate_.cpus().size());
  EXPECT_GE(found.size(), GATE_SENDERS) << "all places are used";
  EXPECT_EQ(refused(GATE_R_IDENTIFIER), 2 * ids.size() + 1) << "all frames are counted";
  EXPECT_TRUE(std::ranges::any_of(found, [&](const RefusedSender& sender) {
    return sender.frame.can_id == of_node(127) && sender.frame.count == ids.size() + 1;
  })) << "who goes on sending stays";
}

TEST_F(GateSenders, OneThatComesBackBeginsAgain) {
  receive(of_node(33));
  receive(of_node(33));
  for (std::uint32_t node = 34; node < 127; ++node)
    for (std::uint32_t priority = 0; priority < 20; ++priority) receive(of_node(node, priority));
  receive(of_node(33));
  const auto found = senders();
  const auto again = std::ranges::find_if(
      found, [](const RefusedSender& sender) { return sender.frame.can_id == of_node(33); });
  ASSERT_NE(again, found.end());
  EXPECT_EQ(again->frame.count, 1U);
}

/// A PGN that is granted to one destination, sent by another node to another one (J1939-21, PDU1).
TEST(GateSendersOfDestinations, AFrameToAnotherDestinationIsNotSentInPlaceOfTheGrantedSender) {
  LoadedGate& gate = LoadedGate::with({.profile = GATE_PROFILE_J1939});
  SlotSpec granted;
  granted.pass = true;
  granted.id = kEff | 0x00ef2105U;
  granted.mask = kForm | 0x03ffffffU;
  granted.subject = 1;
  gate.admit({granted});
  gate.run(Direction::ingress, frame(kEff | 0x18ef4433U, 8));
  EXPECT_TRUE(gates::refused_senders(gate.cpus()).empty());
  const auto unknown = gates::unknown_frames(gate.cpus());
  ASSERT_EQ(unknown.size(), 1U);
  EXPECT_EQ(unknown[0].can_id, kEff | 0x18ef4433U);
  gate.run(Direction::ingress, frame(kEff | 0x18ef2133U, 8));
  EXPECT_EQ(gates::refused_senders(gate.cpus()).size(), 1U) << "the same destination";
}

/// A message of the transport protocol is reported as itself.
TEST(GateSendersOfMessages, ATransportedMessageOfAnotherNodeHasItsOwnIdentifier) {
  LoadedGate& gate = LoadedGate::with({.profile = GATE_PROFILE_J1939});
  SlotSpec dm1;
  dm1.pass = true;
  dm1.id = kEff | 0x18feca05U;
  dm1.mask = kForm | CAN_EFF_MASK;
  dm1.subject = 1;
  dm1.formats = GATE_CLASSIC | GATE_TRANSPORT;
  dm1.max_len = 20;
  gate.admit({dm1});
  Bytes announcement = frame(kEff | 0x18ecff06U, 8);
  const Bytes data = {GATE_TP_BAM, 20, 0, 3, 0xff, 0xca, 0xfe, 0};
  std::ranges::copy(data, announcement.begin() + 8);
  gate.run(Direction::ingress, announcement);
  const auto found = gates::refused_senders(gate.cpus());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].frame.can_id, kEff | 0x18feca06U);
  EXPECT_EQ(found[0].reason, core::FrameReason::identifier);
}

}  // namespace
}  // namespace mlcca::test
