// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's tags: what the gate makes of the broker's replies, frame by frame, in the real program.
#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "daemon/gates/bindings.hpp"
#include "tests/bpf/loaded_gate.hpp"

namespace mlcca::test {
namespace {

using gates::Bindings;
using gates::Direction;
using gates::FoundBinding;

constexpr std::uint32_t kEff = CAN_EFF_FLAG;
constexpr std::uint64_t kSwitch = 0x5377697463682020;    // "Switch  "
constexpr std::uint64_t kSwitches = 0x5377697458585858;  // shares the first half
constexpr std::uint64_t kDistance = 0x44697374616e6365;
constexpr std::uint16_t kTag = 0x3ffe;

/// An event of node 5 with that tag.
constexpr std::uint32_t event_of(std::uint16_t tag) { return kEff | 0x1f400000U | 5U << 14 | tag; }

struct Reply {
  std::uint64_t subject = kDistance;
  std::uint16_t tag = kTag;
  std::uint8_t node = 0x7d;
  std::uint32_t id = kEff | 0x1f5fc004;
};

Bytes half_of(const Reply& r, int half) {
  Bytes bytes = frame(r.id, 8);
  bytes[8] = r.node;
  bytes[9] = static_cast<std::uint8_t>(half);
  bytes[10] = static_cast<std::uint8_t>(r.tag >> 8);
  bytes[11] = static_cast<std::uint8_t>(r.tag);
  for (int i = 0; i < 4; ++i)
    bytes[static_cast<std::size_t>(12 + i)] =
        static_cast<std::uint8_t>(r.subject >> (56 - 8 * (4 * half + i)));
  return bytes;
}

class GateTags : public ::testing::Test {
 protected:
  GateTags() {
    stated_.state(std::vector<gates::StatedBinding>{{kSwitch, kTag, false}});
    gate_.admit({slot(Direction::ingress), slot(Direction::egress), reply(Direction::ingress),
                 reply(Direction::egress)});
  }
  ~GateTags() override { gate_.reset(); }
  static gates::SlotSpec slot(Direction direction, std::uint16_t tag = kTag,
                              std::uint64_t subject = kSwitch) {
    gates::SlotSpec s;
    s.direction = direction;
    s.pass = true;
    s.id = event_of(tag);
    s.mask = CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_EFF_MASK;
    s.subject = subject;
    return s;
  }
  static gates::SlotSpec reply(Direction direction) {
    gates::SlotSpec s = slot(direction, 0, 0);
    s.id = kEff | 0x1f5fc004;
    return s;
  }
  void receive(const Reply& r, Direction direction = Direction::ingress) {
    for (const int half : {0, 1}) receive_half(r, half, direction);
  }
  void receive_half(const Reply& r, int half, Direction direction = Direction::ingress) {
    gate_.run(direction, half_of(r, half), {.local = direction == Direction::egress});
  }
  [[nodiscard]] bool enters(std::uint16_t tag = kTag) {
    return !gate_.run(Direction::ingress, frame(event_of(tag), 8)).dropped;
  }
  [[nodiscard]] bool leaves(std::uint16_t tag = kTag) {
    return !gate_.run(Direction::egress, frame(event_of(tag), 8), {.local = true}).dropped;
  }
  [[nodiscard]] FoundBinding found(std::uint64_t subject = kSwitch) const {
    for (const FoundBinding& f : stated_.found())
      if (f.subject == subject) return f;
    return {};
  }

  LoadedGate& gate_ = LoadedGate::with({.profile = GATE_PROFILE_FAMOUSO});
  Bindings stated_{gate_.table()};
};

TEST_F(GateTags, AReplyAsStatedChangesNothing) {
  const auto before = stated_.news();
  receive({.subject = kSwitch});
  EXPECT_TRUE(enters());
  EXPECT_TRUE(leaves());
  EXPECT_FALSE(found().contradicted);
  EXPECT_EQ(found().dealt, kTag);
  receive({.subject = kDistance, .tag = 0x3ffd});
  EXPECT_TRUE(enters()) << "another subject and another tag";
  EXPECT_EQ(stated_.news(), before + 1) << "that it is dealt at all is news, once";
}

TEST_F(GateTags, TheTagOfAnotherSubjectIsClosedBeforeItsFirstEvent) {
  receive({});
  EXPECT_FALSE(enters());
  EXPECT_FALSE(leaves());
  EXPECT_TRUE(found().contradicted);
  EXPECT_EQ(found().other, kDistance);
  EXPECT_EQ(found().halves, 3);
}

TEST_F(GateTags, OneHalfThatDiffersSuffices) {
  receive_half({}, 0);
  EXPECT_FALSE(enters());
  EXPECT_EQ(found().halves, 1);
  EXPECT_EQ(found().other, kDistance & 0xffffffff00000000U);
}

TEST_F(GateTags, AnEqualFirstHalfProvesNothing) {
  receive_half({.subject = kSwitches}, 0);
  EXPECT_TRUE(enters());
  receive_half({.subject = kSwitches}, 1);
  EXPECT_FALSE(enters());
  EXPECT_EQ(found().other, kSwitches);
}

TEST_F(GateTags, ASecondHalfAloneContradictsToo) {
  receive_half({}, 1);
  EXPECT_FALSE(enters());
  EXPECT_EQ(found().halves, 2);
  EXPECT_EQ(found().other, kDistance & 0xffffffffU);
}

TEST_F(GateTags, ASubjectThatIsDealtAnotherTagLosesItsOwn) {
  receive({.subject = kSwitch, .tag = 0x3ffd});
  EXPECT_FALSE(enters());
  EXPECT_FALSE(leaves());
  EXPECT_EQ(found().halves, 0);
  EXPECT_EQ(found().dealt, 0x3ffd);
}

TEST_F(GateTags, HalvesOfTwoRepliesAreNotJoined) {
  receive_half({.subject = kSwitch, .tag = 0x3ffd}, 0);
  receive_half({.subject = kSwitch, .tag = 0x3ffc}, 1);
  EXPECT_TRUE(enters()) << "another tag in each";
  receive_half({.subject = kSwitch, .tag = 0x3ffd, .node = 0x7c}, 1);
  EXPECT_TRUE(enters()) << "for another node";
}

TEST_F(GateTags, AReplySentHereCountsAsOneThatWasReceived) {
  receive({}, Direction::egress);
  EXPECT_FALSE(enters());
  EXPECT_FALSE(leaves());
}

TEST_F(GateTags, WhatTheGateDoesNotLetOutWasOnNoBus) {
  gates::SlotChanges changes;
  changes.close = {reply(Direction::egress)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  receive({}, Direction::egress);
  EXPECT_TRUE(enters());
}

/// In audit mode it was on the bus, whatever was the matter with it; and is no word of a broker.
TEST_F(GateTags, WhatAuditModeLetsOutIsHeldAgainstWhatIsStated) {
  gates::SlotChanges changes;
  changes.close = {reply(Direction::egress)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  gate_.control().mode = GATE_AUDIT;
  receive({.subject = kSwitch}, Direction::egress);
  EXPECT_EQ(found().dealt, 0);
  EXPECT_FALSE(found().contradicted);
  receive({}, Direction::egress);
  EXPECT_TRUE(found().contradicted) << "no node may send it";
}

TEST_F(GateTags, WhatAClosedGateLetsOutInAuditModeCountsToo) {
  gate_.control().mode = GATE_AUDIT;
  gate_.control().open = 0;
  receive({}, Direction::egress);
  gate_.control().open = 1;
  EXPECT_TRUE(found().contradicted);
}

TEST_F(GateTags, WhatIsMoreThanAdmittedAndLeavesInAuditModeCountsToo) {
  gates::SlotSpec seldom = reply(Direction::egress);
  seldom.per_frame = 3'600'000'000'000;
  gates::SlotChanges changes;
  changes.remove = {reply(Direction::egress)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  gate_.admit({seldom});
  receive({.subject = kSwitch}, Direction::egress);
  EXPECT_FALSE(found().contradicted);
  receive({}, Direction::egress);
  EXPECT_FALSE(found().contradicted) << "it was dropped";
  gate_.control().mode = GATE_AUDIT;
  receive({}, Direction::egress);
  EXPECT_TRUE(found().contradicted);
}

TEST_F(GateTags, WhatCameInWasOnTheBusWhateverBecomesOfIt) {
  gates::SlotChanges changes;
  changes.close = {reply(Direction::ingress)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  receive({});
  EXPECT_FALSE(enters());
}

TEST_F(GateTags, TheGateListensWhileItIsClosed) {
  gate_.control().open = 0;
  receive({});
  gate_.control().open = 1;
  EXPECT_FALSE(enters());
}

TEST_F(GateTags, AReplyThatIsNoBrokersClosesAndOpensNothing) {
  const Reply forged{.id = kEff | 0x1f5f4004};  // of node 0x7d
  receive(forged);
  EXPECT_FALSE(enters());
  receive({.subject = kSwitch, .id = forged.id});
  EXPECT_FALSE(found().confirmed);
  receive_half({.subject = kSwitch}, 0);
  receive_half({.subject = kSwitch, .id = forged.id}, 1);
  EXPECT_FALSE(found().confirmed) << "half of it is";
  EXPECT_FALSE(stated_.found().empty());
}

TEST_F(GateTags, OtherFramesOfThatTagAreNoReplies) {
  Bytes short_one = half_of({}, 0);
  short_one[4] = 7;
  gate_.run(Direction::ingress, short_one);
  Bytes third = half_of({}, 0);
  third[9] = 2;
  gate_.run(Direction::ingress, third);
  receive({.id = kEff | CAN_RTR_FLAG | 0x1f5fc004});
  receive({.id = 4});
  receive({.id = kEff | 0x1f5fc003});
  EXPECT_TRUE(enters());
}

TEST_F(GateTags, OpensAgainWhenTheTagIsDealtAsStatedAndUserSpaceSaysSo) {
  receive({});
  EXPECT_FALSE(found().confirmed);
  receive({.subject = kSwitch});
  EXPECT_TRUE(found().confirmed);
  EXPECT_FALSE(enters()) << "not by itself";
  receive({});
  EXPECT_FALSE(found().confirmed) << "a contradiction since";
  receive({.subject = kSwitch});
  ASSERT_TRUE(stated_.end_contradictions(kSwitch));
  EXPECT_TRUE(enters());
  EXPECT_TRUE(leaves());
  EXPECT_FALSE(found().contradicted);
}

TEST_F(GateTags, ASlotThatComesLaterIsShutAsWell) {
  receive({});
  gates::SlotChanges changes;
  changes.remove = {slot(Direction::ingress)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  gate_.admit({slot(Direction::ingress)});
  EXPECT_FALSE(enters());
  ASSERT_TRUE(stated_.end_contradictions(kSwitch));
  EXPECT_TRUE(enters());
}

TEST_F(GateTags, OutlastTheDaemonAndEndWithTheStatement) {
  receive({});
  const std::vector<gates::StatedBinding> same{{kSwitch, kTag, false}};
  Bindings(gate_.table()).state(same);
  EXPECT_TRUE(found().contradicted) << "another daemon states the same";
  stated_.state(std::vector<gates::StatedBinding>{{kSwitch, 0x3ff0, false}});
  EXPECT_FALSE(found().contradicted);
  receive({.subject = kDistance, .tag = 0x3ff0});
  EXPECT_TRUE(found().contradicted);
  stated_.state({});
  EXPECT_TRUE(stated_.found().empty());
}

TEST_F(GateTags, ATagThatIsNotKnownIsLearnedFromAWholeReply) {
  stated_.state(std::vector<gates::StatedBinding>{{kSwitch, 0, false}, {GATE_SUBSCRIBE, 0, false}});
  receive_half({.subject = kSwitch}, 1);
  EXPECT_EQ(found().dealt, 0);
  receive({.subject = kSwitch, .id = kEff | 0x1f5f4004});
  EXPECT_EQ(found().dealt, 0) << "no broker's";
  receive({.subject = kSwitch});
  EXPECT_EQ(found().dealt, kTag);
  EXPECT_EQ(found(GATE_SUBSCRIBE).dealt, 0);
  EXPECT_FALSE(found().contradicted);
  receive({.subject = kSwitch, .tag = 0x3ffb});
  EXPECT_EQ(found().dealt, 0x3ffb);
}

TEST_F(GateTags, ATagThatIsDealtToAnotherBeforeItIsStatedIsTakenBack) {
  stated_.state(std::vector<gates::StatedBinding>{{.subject = kSwitch}, {.subject = kDistance}});
  receive({.subject = kSwitch});
  const FoundBinding seen = found();
  EXPECT_EQ(seen.dealt, kTag);
  receive({});
  EXPECT_EQ(found().dealt, 0) << "the last word counts";
  EXPECT_EQ(found(kDistance).dealt, kTag);
  // Whoever gives it by what was seen before finds it contradicted.
  stated_.move(seen, kTag);
  EXPECT_TRUE(found().contradicted);
  gate_.admit({});
  gates::SlotChanges changes;
  changes.remove = {slot(Direction::ingress)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  gate_.admit({slot(Direction::ingress)});
  EXPECT_FALSE(enters());
}

TEST_F(GateTags, OneHalfOfAnotherSubjectTakesItBackAsWell) {
  stated_.state(std::vector<gates::StatedBinding>{{.subject = kSwitch}});
  receive({.subject = kSwitch});
  receive_half({}, 0);
  EXPECT_EQ(found().dealt, 0);
}

TEST_F(GateTags, ATagThatMovesIsOpenAndSupervisedAtOnce) {
  stated_.state(std::vector<gates::StatedBinding>{{.subject = kSwitch, .dealt = kTag}});
  EXPECT_EQ(found().dealt, kTag) << "of a gate that has not seen it";
  stated_.move(found(), kTag);
  EXPECT_EQ(found().etag, kTag);
  EXPECT_FALSE(found().contradicted);
  receive({.subject = kSwitch, .tag = 0x3ffb});
  EXPECT_TRUE(found().contradicted);
  stated_.move(found(), 0x3ffb);
  EXPECT_FALSE(found().contradicted);
  gate_.admit({slot(Direction::ingress, 0x3ffb)});
  EXPECT_TRUE(enters(0x3ffb));
  EXPECT_FALSE(enters()) << "the tag that it had stays shut";
  receive({.tag = 0x3ffb});
  EXPECT_FALSE(enters(0x3ffb));
}

TEST_F(GateTags, WhatTheBrokerHasDealtOutlastsThatTheTagIsGivenUp) {
  stated_.state(std::vector<gates::StatedBinding>{{.subject = kSwitch}});
  receive({.subject = kSwitch});
  stated_.move(found(), kTag);
  stated_.state(std::vector<gates::StatedBinding>{{.subject = kSwitch, .dealt = kTag}});
  EXPECT_EQ(found().etag, 0);
  EXPECT_EQ(found().dealt, kTag);
}

TEST_F(GateTags, SubscriptionsAreShutLikeAChannel) {
  stated_.state(std::vector<gates::StatedBinding>{{GATE_SUBSCRIBE, 0x3fff, false}});
  gate_.admit({slot(Direction::ingress, 0x3fff, 0)});
  EXPECT_TRUE(enters(0x3fff));
  receive({.tag = 0x3fff});
  EXPECT_FALSE(enters(0x3fff));
  EXPECT_TRUE(enters());
}

TEST_F(GateTags, OfAThousandBindingsTheRightOneIsFound) {
  std::vector<gates::StatedBinding> many;
  for (std::uint16_t i = 0; i < GATE_BINDINGS - 1; ++i)
    many.push_back({0x1000000000000000U + i, static_cast<std::uint16_t>(0x64 + i), false});
  many.push_back({kSwitch, kTag, false});
  stated_.state(many);
  receive({});
  int contradicted = 0;
  for (const FoundBinding& f : stated_.found()) contradicted += f.contradicted ? 1 : 0;
  EXPECT_EQ(contradicted, 1);
  EXPECT_FALSE(enters());
}

TEST(GateTagsOfOthers, AreIgnored) {
  auto& gate = LoadedGate::with({.profile = GATE_PROFILE_RAW});
  Bindings(gate.table()).state(std::vector<gates::StatedBinding>{{kSwitch, kTag, false}});
  for (const int half : {0, 1}) gate.run(Direction::ingress, half_of({}, half));
  EXPECT_FALSE(Bindings(gate.table()).found().at(0).contradicted);
  gate.reset();
}

}  // namespace
}  // namespace mlcca::test
