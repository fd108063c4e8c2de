// SPDX-License-Identifier: BSD-2-Clause
// Messages of J1939's transport protocol at the real gate: what is announced is judged as a frame
// of its PGN, and packets pass in their turn only.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/gates/counters.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr std::uint32_t kEff = CAN_EFF_FLAG;
constexpr std::uint32_t kWhole = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_EFF_MASK;
constexpr std::uint32_t kNoPriority = ~0x1c000000U;
constexpr std::uint32_t kNoDestination = ~0xff00U;
constexpr std::uint64_t kHour = 3'600'000'000'000;  // ns

constexpr std::uint32_t kPgn = 0xfeca;
constexpr std::uint32_t kPdu1 = 0x1200;  // is sent to somebody
constexpr unsigned kMost = 20;

struct Announcement {
  std::uint32_t pgn = kPgn;
  unsigned size = kMost;
  unsigned packets = 3;
  std::uint8_t control = GATE_TP_BAM;
  std::uint32_t id = 0x18ecff05;
};

Bytes announce(const Announcement& a) {
  Bytes bytes = frame(kEff | a.id, 8);
  const auto octet = [](unsigned value) { return static_cast<std::uint8_t>(value); };
  const std::vector<std::uint8_t> data = {
      a.control, octet(a.size), octet(a.size >> 8), octet(a.packets),
      0xff,      octet(a.pgn),  octet(a.pgn >> 8),  octet(a.pgn >> 16)};
  std::copy(data.begin(), data.end(), bytes.begin() + 8);
  return bytes;
}

Bytes packet(unsigned number, std::uint32_t id = 0x18ebff05) {
  Bytes bytes = frame(kEff | id, 8);
  bytes[8] = static_cast<std::uint8_t>(number);
  return bytes;
}

SlotSpec slot(std::uint32_t id, std::uint32_t open = 0) {
  SlotSpec s;
  s.pass = true;
  s.mask = kWhole & ~open;
  s.id = (kEff | id) & s.mask;
  s.max_len = kMost;
  s.formats = GATE_CLASSIC | GATE_TRANSPORT;
  s.subject = 1;
  return s;
}
SlotSpec denied(SlotSpec s) {
  s.pass = false;
  return s;
}
/// Control traffic of the transport protocol.
std::vector<SlotSpec> control(bool pass) {
  std::vector<SlotSpec> out;
  for (const std::uint32_t id : {0x00ec0000U, 0x00eb0000U}) {
    SlotSpec s = slot(id, 0x1c00ffff);
    s.formats = GATE_CLASSIC;
    s.max_len = 8;
    s.subject = 0;
    s.pass = pass;
    out.push_back(s);
  }
  return out;
}

// --- what announces a message --------------------------------------------------------------------

struct Row {
  std::string name;
  std::vector<SlotSpec> slots;
  Announcement announcement;
  gate_reason reason;
};

std::vector<Row> rows() {
  const SlotSpec dm1 = slot(0x18feca05);
  const SlotSpec any_priority = slot(0x18feca05, ~kNoPriority);
  SlotSpec plain = dm1;
  plain.formats = GATE_CLASSIC;
  plain.max_len = 8;
  SlotSpec fd = dm1;
  fd.formats = GATE_CLASSIC | GATE_FD;
  fd.max_len = 64;
  SlotSpec most = dm1;
  most.max_len = GATE_TP_MOST;
  const SlotSpec to_all = slot(0x1812ff05);
  const SlotSpec to_one = slot(0x18122105);
  const SlotSpec to_any = slot(0x18120005, ~kNoDestination);
  return {
      {"Passes", {dm1}, {}, GATE_R_PASSED},
      {"ShorterPasses", {dm1}, {.size = 9, .packets = 2}, GATE_R_PASSED},
      {"LongerThanGranted", {dm1}, {.size = 21, .packets = 3}, GATE_R_LENGTH},
      {"FitsOneFrame", {dm1}, {.size = 8, .packets = 2}, GATE_R_MALFORMED},
      {"Empty", {dm1}, {.size = 0, .packets = 0}, GATE_R_MALFORMED},
      {"TooFewPackets", {dm1}, {.packets = 2}, GATE_R_MALFORMED},
      {"TooManyPackets", {dm1}, {.packets = 4}, GATE_R_MALFORMED},
      {"PacketsOf256", {dm1}, {.packets = 259}, GATE_R_PASSED},  // one octet: 3
      {"LongestPasses", {most}, {.size = 1785, .packets = 255}, GATE_R_PASSED},
      {"BeyondTheLongest", {most}, {.size = 1786, .packets = 255}, GATE_R_LENGTH},
      {"AnotherPgn", {dm1}, {.pgn = 0xfecb}, GATE_R_UNKNOWN},
      {"AnotherDataPage", {dm1}, {.pgn = 0x1feca}, GATE_R_UNKNOWN},
      {"NoPgn", {dm1}, {.pgn = 0x4feca}, GATE_R_MALFORMED},
      {"AnotherSource", {dm1}, {.id = 0x18ecff06}, GATE_R_IDENTIFIER},
      {"AnotherPriority", {dm1}, {.id = 0x1cecff05}, GATE_R_IDENTIFIER},
      {"AnyPriorityPasses", {any_priority}, {.id = 0x1cecff05}, GATE_R_PASSED},
      {"Refused", {denied(dm1)}, {}, GATE_R_DENIED},
      {"WithoutTransport", {plain}, {}, GATE_R_FORMAT},
      {"LongInFdFramesOnly", {fd}, {}, GATE_R_FORMAT},
      {"ToOne", {dm1}, {.id = 0x18ec2105}, GATE_R_FORMAT},
      {"RequestToSend", {dm1}, {.control = GATE_TP_RTS, .id = 0x18ec2105}, GATE_R_FORMAT},
      {"RequestToSendOfNoChannel",
       {dm1},
       {.pgn = 0xfecb, .control = GATE_TP_RTS, .id = 0x18ec2105},
       GATE_R_UNKNOWN},
      {"AnnouncedToAll", {to_all}, {.pgn = kPdu1}, GATE_R_PASSED},
      {"AnnouncedToAllAndMeantForOne", {to_one}, {.pgn = kPdu1}, GATE_R_UNKNOWN},
      {"AnnouncedToAllNodes", {to_any}, {.pgn = kPdu1}, GATE_R_PASSED},
      {"DestinationInThePgn", {to_any}, {.pgn = kPdu1 | 0x21}, GATE_R_MALFORMED},
      {"AnotherPage", {dm1}, {.id = 0x19ecff05}, GATE_R_UNKNOWN},
      {"ClearToSend", {dm1}, {.control = 17}, GATE_R_UNKNOWN},
      {"Abort", {dm1}, {.control = 255}, GATE_R_UNKNOWN},
  };
}

class Announcements : public ::testing::TestWithParam<Row> {};

TEST_P(Announcements, AreJudgedAsFramesOfTheirPgnInBothDirections) {
  for (const auto direction : {Direction::ingress, Direction::egress}) {
    auto slots = GetParam().slots;
    for (auto& s : slots) s.direction = direction;
    auto& gate = LoadedGate::with({.profile = GATE_PROFILE_J1939});
    gate.admit(slots);
    const Sender sender{.local = direction == Direction::egress};
    const auto outcome = gate.run(direction, announce(GetParam().announcement), sender);
    EXPECT_EQ(outcome.dropped, GetParam().reason != GATE_R_PASSED);
    EXPECT_EQ(gates::reason_counters(gate.cpus(), direction).at(GetParam().reason), 1U);
    // Only behind one that passed does a packet.
    EXPECT_EQ(gate.run(direction, packet(1), sender).dropped, outcome.dropped);
  }
}

INSTANTIATE_TEST_SUITE_P(Table, Announcements, ::testing::ValuesIn(rows()),
                         [](const auto& row) { return row.param.name; });

// --- what follows --------------------------------------------------------------------------------

class Transport : public ::testing::Test {
 protected:
  void admit(const std::vector<SlotSpec>& slots) { gate_.admit(slots); }
  bool passes(const Bytes& bytes, const Sender& sender = {},
              Direction direction = Direction::ingress) {
    return !gate_.run(direction, bytes, sender).dropped;
  }
  std::uint64_t counted(gate_reason reason, Direction direction = Direction::ingress) {
    return gates::reason_counters(gate_.cpus(), direction).at(reason);
  }
  gate_session& session(std::uint8_t source = 5, Direction direction = Direction::ingress) {
    return gate_.table().sessions[std::to_underlying(direction)][source];
  }
  gates::SlotCounters counters(const SlotSpec& s) {
    return gates::slot_counters(gate_.table(), gate_.cpus(), gate_.slots().find(s).value());
  }

  LoadedGate& gate_ = LoadedGate::with({.profile = GATE_PROFILE_J1939});
  SlotSpec dm1_ = slot(0x18feca05);
};

TEST_F(Transport, PacketsPassInTheirTurnAndNoFurther) {
  admit({dm1_});
  EXPECT_FALSE(passes(packet(1))) << "nothing is announced";
  EXPECT_TRUE(passes(announce({})));
  EXPECT_FALSE(passes(packet(2))) << "the first is missing";
  EXPECT_TRUE(passes(packet(1)));
  EXPECT_FALSE(passes(packet(1))) << "twice";
  EXPECT_TRUE(passes(packet(2)));
  EXPECT_TRUE(passes(packet(3)));
  EXPECT_FALSE(passes(packet(4)));
  EXPECT_FALSE(passes(packet(1)));
  EXPECT_EQ(session().state, 0U);
  EXPECT_EQ(counted(GATE_R_PASSED), 4U);
  EXPECT_EQ(counted(GATE_R_FRAGMENT), 5U);
  EXPECT_EQ(counters(dm1_).passed, 4U);
  EXPECT_EQ(counters(dm1_).dropped, 2U) << "those without a session are nobody's";
}

/// Nothing of these has a slot. The report has their sender nonetheless.
TEST_F(Transport, WhatAnnouncesNothingThatCanBeAndWhatNothingAnnouncesHaveASender) {
  admit({dm1_});
  EXPECT_FALSE(passes(packet(1)));
  EXPECT_FALSE(passes(announce({.size = 8, .packets = 2})));
  auto found = gates::refused_senders(gate_.cpus());
  ASSERT_EQ(found.size(), 2U);
  std::ranges::sort(found, {}, &gates::RefusedSender::reason);
  EXPECT_EQ(found[0].reason, core::FrameReason::malformed);
  EXPECT_EQ(found[0].frame.can_id, kEff | 0x18feca05) << "of the message that it announces";
  EXPECT_EQ(found[1].reason, core::FrameReason::fragment);
  EXPECT_EQ(found[1].frame.can_id, kEff | 0x18ebff05);
  for (const auto& sender : found) EXPECT_TRUE(sender.is_without_slot());
}

TEST_F(Transport, TheLongestMessagePassesWhole) {
  dm1_.max_len = GATE_TP_MOST;
  admit({dm1_});
  EXPECT_TRUE(passes(announce({.size = 1785, .packets = 255})));
  for (unsigned i = 1; i <= 255; ++i) EXPECT_TRUE(passes(packet(i))) << i;
  EXPECT_FALSE(passes(packet(0)));
  EXPECT_EQ(session().state, 0U);
}

TEST_F(Transport, AFrameAloneIsAsLongAsAFrame) {
  admit({dm1_});
  EXPECT_TRUE(passes(frame(kEff | 0x18feca05, 8)));
  EXPECT_FALSE(passes(frame(kEff | 0x18feca05, 8, true)));
}

TEST_F(Transport, OnlyWholeClassicFramesCount) {
  admit({dm1_});
  Bytes remote = announce({});
  remote[3] |= 0x40;
  EXPECT_FALSE(passes(remote));
  Bytes little = announce({});
  little[4] = 7;
  EXPECT_FALSE(passes(little));
  Bytes fd = frame(kEff | 0x18ecff05, 8, true);
  const Bytes bam = announce({});
  std::copy(bam.begin() + 8, bam.end(), fd.begin() + 8);
  EXPECT_FALSE(passes(fd));
  EXPECT_TRUE(passes(announce({})));
  Bytes short_packet = packet(1);
  short_packet[4] = 4;
  EXPECT_FALSE(passes(short_packet));
  EXPECT_FALSE(passes(packet(1, 0x18eb2105))) << "to one";
  EXPECT_FALSE(passes(packet(1, 0x1cebff05))) << "of another priority";
  EXPECT_FALSE(passes(packet(1, 0x19ebff05))) << "of another page";
  EXPECT_TRUE(passes(packet(1)));
}

TEST_F(Transport, SourcesDoNotMeet) {
  SlotSpec other = slot(0x18fecb06);
  other.subject = 2;
  admit({dm1_, other});
  EXPECT_TRUE(passes(announce({})));
  EXPECT_TRUE(passes(announce({.pgn = 0xfecb, .size = 9, .packets = 2, .id = 0x18ecff06})));
  EXPECT_TRUE(passes(packet(1)));
  EXPECT_TRUE(passes(packet(1, 0x18ebff06)));
  EXPECT_FALSE(passes(packet(2, 0x18ebff07)));
  EXPECT_TRUE(passes(packet(2, 0x18ebff06)));
  EXPECT_FALSE(passes(packet(3, 0x18ebff06)));
  EXPECT_TRUE(passes(packet(2)));
  EXPECT_TRUE(passes(packet(3)));
  EXPECT_EQ(counters(other).passed, 3U);
}

TEST_F(Transport, EachAnnouncementFromTheBusEndsTheOneBefore) {
  admit({dm1_});
  EXPECT_TRUE(passes(announce({})));
  EXPECT_TRUE(passes(packet(1)));
  EXPECT_TRUE(passes(announce({.size = 9, .packets = 2})));
  EXPECT_FALSE(passes(packet(2)));
  EXPECT_TRUE(passes(packet(1)));
  EXPECT_FALSE(passes(announce({.pgn = 0xfecb})));
  EXPECT_FALSE(passes(packet(2))) << "of what was refused";
  EXPECT_TRUE(passes(announce({})));
}

TEST_F(Transport, WhatIsRefusedOnItsWayOutEndsNothing) {
  dm1_.direction = Direction::egress;
  dm1_.uid = 0;
  admit({dm1_});
  const auto out = [&](const Bytes& bytes, const Sender& sender = {.local = true}) {
    return passes(bytes, sender, Direction::egress);
  };
  EXPECT_TRUE(out(announce({})));
  EXPECT_FALSE(out(announce({}), {.ingress_ifindex = kOther}));
  EXPECT_FALSE(out(announce({.pgn = 0xfecb})));
  EXPECT_FALSE(out(packet(1), {.ingress_ifindex = kOther})) << "of another sender";
  EXPECT_FALSE(out(packet(1), {})) << "of the kernel";
  EXPECT_TRUE(out(packet(1)));
  EXPECT_FALSE(passes(packet(2))) << "nothing has come from the bus";
  EXPECT_TRUE(out(packet(2)));
}

TEST_F(Transport, AMessageEndsWithItsGrant) {
  admit({dm1_});
  EXPECT_TRUE(passes(announce({})));
  EXPECT_TRUE(passes(packet(1)));
  ASSERT_TRUE(
      gate_.slots().apply({.close = {dm1_}, .add = {}, .remove = {}, .open = {}, .police = {}}));
  EXPECT_FALSE(passes(packet(2)));
  EXPECT_EQ(counted(GATE_R_DENIED), 1U);
  ASSERT_TRUE(
      gate_.slots().apply({.close = {}, .add = {}, .remove = {dm1_}, .open = {}, .police = {}}));
  EXPECT_FALSE(passes(packet(2)));
  EXPECT_EQ(counted(GATE_R_FRAGMENT), 1U);
  // Granted again, in another slot: what was announced before was announced to another one.
  SlotSpec again = dm1_;
  again.max_len = 30;
  ASSERT_TRUE(gate_.slots().apply(
      {.close = {}, .add = {slot(0x18fecc05), again}, .remove = {}, .open = {}, .police = {}}));
  EXPECT_FALSE(passes(packet(2)));
}

TEST_F(Transport, ClosedGatesPassNoPacket) {
  admit({dm1_});
  EXPECT_TRUE(passes(announce({})));
  gate_.control().open = 0;
  EXPECT_FALSE(passes(packet(1)));
  EXPECT_EQ(counted(GATE_R_CLOSED), 1U);
}

TEST_F(Transport, APacketThatIsLateIsOfNoMessage) {
  admit({dm1_});
  EXPECT_TRUE(passes(announce({})));
  const std::uint64_t announced = session().latest;
  EXPECT_TRUE(passes(packet(1)));
  EXPECT_GT(session().latest, announced) << "each packet has its own time";
  session().latest -= GATE_TP_TIMEOUT;
  EXPECT_FALSE(passes(packet(2)));
  EXPECT_EQ(counted(GATE_R_FRAGMENT), 1U);
}

TEST_F(Transport, TheAnnouncementPaysForTheMessage) {
  // Four frames to an event of an hour, and one event early.
  dm1_.per_frame = kHour / 4;
  dm1_.tolerance = 2 * kHour - dm1_.per_frame;
  admit({dm1_});
  for (int event = 0; event < 2; ++event) {
    EXPECT_TRUE(passes(announce({})));
    for (unsigned i = 1; i <= 3; ++i) EXPECT_TRUE(passes(packet(i)));
  }
  EXPECT_FALSE(passes(announce({})));
  EXPECT_FALSE(passes(packet(1)));
  EXPECT_EQ(counted(GATE_R_EXCESS), 1U);
  EXPECT_EQ(counters(dm1_).excess, 1U);
}

TEST_F(Transport, BytesArePaidForAsTheyAreAnnounced) {
  dm1_.per_byte = kHour / 20 * 256;
  admit({dm1_});
  EXPECT_TRUE(passes(announce({})));
  EXPECT_FALSE(passes(announce({.size = 9, .packets = 2})));
}

TEST_F(Transport, ExcessThatPassesOpensItsMessage) {
  dm1_.per_frame = kHour;
  dm1_.excess_passes = true;
  admit({dm1_});
  for (int event = 0; event < 2; ++event) {
    EXPECT_TRUE(passes(announce({})));
    for (unsigned i = 1; i <= 3; ++i) EXPECT_TRUE(passes(packet(i)));
  }
  EXPECT_EQ(counters(dm1_).excess, 1U);
}

TEST_F(Transport, AMessageIsOneEvent) {
  dm1_.period = kHour;
  admit({dm1_});
  const gate_watch& watch = gate_.table().watches[gate_.slots().find(dm1_).value()];
  EXPECT_TRUE(passes(announce({})));
  for (unsigned i = 1; i <= 3; ++i) EXPECT_TRUE(passes(packet(i)));
  EXPECT_NE(watch.last, 0U);
  EXPECT_EQ(watch.last_gap, 0U) << "packets are no events";
}

TEST_F(Transport, ForwardedMessagesLeaveAsWhatTheyCameInAs) {
  SlotSpec other = slot(0x18fecb05);
  other.subject = 2;
  dm1_.origin = gate_origin(1, 1);
  other.origin = gate_origin(2, 1);
  admit({dm1_, other});
  const auto out = gate_.run(Direction::ingress, announce({}));
  EXPECT_EQ(out.mark, gate_ingress_token(kToken, kIfindex, dm1_.origin));
  EXPECT_EQ(gate_.run(Direction::ingress, packet(1)).mark, out.mark);

  for (SlotSpec* s : {&dm1_, &other}) {
    s->direction = Direction::egress;
    s->source = kOther;
  }
  gate_.reset();
  admit({dm1_});
  const auto marked = [](const SlotSpec& s) {
    return Sender{.mark = gate_ingress_token(kToken, kOther, s.origin), .ingress_ifindex = kOther};
  };
  const auto leaves = [&](const Bytes& bytes, const SlotSpec& as) {
    return passes(bytes, marked(as), Direction::egress);
  };
  EXPECT_TRUE(leaves(announce({}), dm1_));
  EXPECT_TRUE(leaves(packet(1), dm1_));
  // The same rule of can-gw has brought a message here that is not granted here.
  EXPECT_FALSE(leaves(announce({.pgn = 0xfecb}), other));
  EXPECT_FALSE(leaves(packet(2), other));
  EXPECT_EQ(counted(GATE_R_SOURCE, Direction::egress), 1U);
  EXPECT_FALSE(leaves(announce({}), other)) << "one that was admitted as another";
}

// --- control traffic -----------------------------------------------------------------------------

TEST_F(Transport, WhatIsNoChannelsIsControlTraffic) {
  auto slots = control(true);
  slots.push_back(dm1_);
  SlotSpec refused = denied(slot(0x18fecb05));
  slots.push_back(refused);
  admit(slots);
  EXPECT_TRUE(passes(announce({.pgn = 0xfecc})));
  EXPECT_TRUE(passes(packet(7))) << "of control traffic no turn is known";
  EXPECT_TRUE(passes(announce({.pgn = 0xfecc, .control = GATE_TP_RTS, .id = 0x18ec2105})));
  EXPECT_TRUE(passes(announce({.control = 17, .id = 0x18ec0521})));
  EXPECT_FALSE(passes(announce({.pgn = 0xfecb}))) << "a channel's number is that channel's alone";
  EXPECT_FALSE(passes(announce({.pgn = 0xfecb, .control = GATE_TP_RTS, .id = 0x18ec2105})));
  EXPECT_TRUE(passes(announce({})));
  EXPECT_FALSE(passes(packet(2)));
  EXPECT_TRUE(passes(packet(1)));
  EXPECT_EQ(counters(dm1_).passed, 2U);
  EXPECT_TRUE(passes(announce({.pgn = 0xfecc})));
  EXPECT_TRUE(passes(packet(2)));
  EXPECT_EQ(counters(dm1_).passed, 2U) << "another message has begun";
}

/// The number is a channel's, whatever the destination. The frame is not said to be sent in place
/// of the granted one.
TEST_F(Transport, AMessageToAnotherDestinationOfAChannelsNumberIsNoControlTraffic) {
  auto slots = control(true);
  slots.push_back(slot(0x18122105));
  admit(slots);
  EXPECT_FALSE(passes(announce({.pgn = kPdu1})));
  EXPECT_FALSE(passes(announce({.pgn = kPdu1, .control = GATE_TP_RTS, .id = 0x18ec2205})));
  EXPECT_TRUE(gates::refused_senders(gate_.cpus()).empty());
  const auto unknown = gates::unknown_frames(gate_.cpus());
  ASSERT_EQ(unknown.size(), 2U);
  EXPECT_EQ(unknown[0].can_id, kEff | 0x18122205);
  EXPECT_EQ(unknown[1].can_id, kEff | 0x1812ff05);
  EXPECT_FALSE(passes(announce({.pgn = kPdu1, .control = GATE_TP_RTS, .id = 0x18ec2106})));
  EXPECT_EQ(gates::refused_senders(gate_.cpus()).size(), 1U) << "another node, the same place";
}

TEST_F(Transport, WithoutControlTrafficThePgnIsReported) {
  auto slots = control(false);
  slots.push_back(dm1_);
  admit(slots);
  EXPECT_FALSE(passes(announce({.pgn = 0xfecb})));
  const auto unknown = gates::unknown_frames(gate_.cpus());
  ASSERT_EQ(unknown.size(), 1U);
  EXPECT_EQ(unknown[0].can_id, kEff | 0x18fecb05);
  EXPECT_FALSE(passes(packet(1)));
  EXPECT_EQ(counters(slots[1]).dropped, 1U);
  EXPECT_FALSE(passes(announce({.pgn = 0xfecb, .control = GATE_TP_RTS, .id = 0x18ec2105})));
  EXPECT_EQ(counters(slots[0]).dropped, 1U);
}

}  // namespace
}  // namespace mlcca::test
