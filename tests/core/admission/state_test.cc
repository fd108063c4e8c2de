// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/state.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

Admission one_more_subscriber(AdmissionId id, AttributeSet attributes) {
  Admission a;
  a.id = id;
  a.subscriber = subscriber("late", network(kRobotCan), attributes);
  return a;
}

System only_a_logger() {
  System system = robot(5);
  system.publishers[0].attributes.set(Attribute::omission, 10);
  system.subscribers = {
      subscriber("logger", network(kRobotCan), heart_beat().set(Attribute::omission, 10))};
  return system;
}

TEST(StateTest, AProposalThatIsNotAcceptedLeavesNoTrace) {
  State state(robot(0));
  const State before(robot(0));
  {
    const Proposal p = state.propose(one_more_subscriber(1, heart_beat()));
    EXPECT_TRUE(p.fit());
  }
  EXPECT_EQ(state.members().subscribers_of(0).size(), 1U);
  EXPECT_TRUE(state.ledger().same_promises(before.ledger()));
  EXPECT_EQ(only_verdict(state).subscribers.size(), 1U);
}

TEST(StateTest, ALaterRequestIsRefusedAndNoOtherChannelSuffers) {
  State state(only_a_logger());
  ASSERT_TRUE(only_verdict(state).granted);
  {
    const Proposal p = state.propose(one_more_subscriber(1, heart_beat()));
    EXPECT_FALSE(p.fit());
    ASSERT_EQ(p.verdicts().size(), 1U);
    EXPECT_FALSE(p.verdicts()[0]->granted);
  }
  EXPECT_TRUE(only_verdict(state).granted);
}

TEST(StateTest, AcceptedAdmissionsTakePartInLaterDecisions) {
  State state(robot(0));
  state.propose(one_more_subscriber(1, heart_beat().set(Attribute::omission, 1))).accept();
  EXPECT_EQ(only_verdict(state).requirement[Attribute::omission], 1U);
  state.decide();
  EXPECT_EQ(only_verdict(state).requirement[Attribute::omission], 1U);
  EXPECT_TRUE(state.remove(1));
  EXPECT_FALSE(state.remove(1));
  state.settle();
  EXPECT_EQ(only_verdict(state).requirement[Attribute::omission], 2U);
}

/// One network that carries 250 bytes/s: the first channel, with two publishers, is more important
/// than the second. Each event stream needs 100.
System three_for_two() {
  System system;
  Network net;
  net.name = "wire";
  net.kind = NetworkKind::other;
  net.provision.set(Attribute::bandwidth, 250).set(Attribute::max_payload, 8);
  system.networks.push_back(net);
  for (std::size_t c = 0; c < 2; ++c) {
    EventChannel channel;
    channel.name = "c" + std::to_string(c);
    channel.subject = c + 1;
    channel.importance = c == 0 ? 7 : 0;
    channel.attributes.set(Attribute::bandwidth, 100).set(Attribute::max_payload, 8);
    system.channels.push_back(channel);
    system.subscribers.push_back(
        subscriber("s" + std::to_string(c), network(0), channel.attributes));
    system.subscribers.back().channel = c;
  }
  for (const auto& [name, channel] : {std::pair("p1", 0U), {"p2", 0U}, {"p3", 1U}}) {
    Publisher p;
    p.name = name;
    p.channel = channel;
    p.place = network(0);
    p.attributes = system.channels[channel].attributes;
    system.publishers.push_back(p);
  }
  return system;
}

TEST(StateTest, WhatWasGrantedBeforeIsGrantedAgainFirst) {
  State state(three_for_two());
  EXPECT_EQ(state.grants(0), (Grants{0, {{"p1", 0, "wire"}, {"p2", 0, "wire"}}}));
  EXPECT_EQ(state.grants(1), (Grants{}));
  // As it would be if p2 had come last, and was refused.
  state.decide({{0, {0, {{"p1", 0, "wire"}}}}, {1, {0, {{"p3", 0, "wire"}}}}});
  EXPECT_EQ(state.grants(0), (Grants{0, {{"p1", 0, "wire"}}}));
  EXPECT_EQ(state.grants(1), (Grants{0, {{"p3", 0, "wire"}}}));
}

TEST(StateTest, GrantsOfUnknownEndpointsAreForgotten) {
  State state(three_for_two());
  state.decide({{0, {0, {{"p1", 9, "wire"}, {"p2", 0, "air"}}}}, {1, {4, {{"p3", 0, "wire"}}}}});
  EXPECT_EQ(state.grants(0).deliveries.size(), 2U) << "as from scratch";
}

TEST(StateTest, AProposalDecidesAsIfDecidedFromScratch) {
  State state(robot(0));
  Admission a;
  a.id = 7;
  Publisher second = state.system().publishers[0];
  second.name = "second";
  second.node = 0x21;
  a.publisher = second;
  a.subscriber = subscriber("app", gateway(kBridge), heart_beat());
  Proposal p = state.propose(a);
  ASSERT_TRUE(p.fit());
  const GateChanges changes = p.changes(kBridge);
  const GateState before = [&] {
    State other(robot(0));
    return other.gate_state(kBridge);
  }();
  std::move(p).accept();
  const GateState incremental = state.gate_state(kBridge);
  EXPECT_EQ(changes, gate_changes_between(before, incremental));
  State from_scratch(robot(0));
  from_scratch.restore(a);
  from_scratch.decide();
  EXPECT_TRUE(state.ledger().same_promises(from_scratch.ledger()));
  state.decide();
  EXPECT_TRUE(state.ledger().same_promises(from_scratch.ledger()));
  EXPECT_EQ(state.gate_state(kBridge), incremental);
}

TEST(StateTest, ReleaseRestoresTheLedgerExactly) {
  State state(robot(0));
  const State before(robot(0));
  Admission a;
  a.id = 3;
  Publisher second = state.system().publishers[0];
  second.node = 0x22;
  second.attributes.set(Attribute::period, 25'000'001);
  a.publisher = second;
  Proposal p = state.propose(a);
  ASSERT_TRUE(p.fit());
  std::move(p).accept();
  EXPECT_FALSE(state.ledger().same_promises(before.ledger()));
  state.remove(3);
  state.settle();
  EXPECT_TRUE(state.ledger().same_promises(before.ledger()));
}

TEST(StateTest, AReleasedChannelIsRefused) {
  State state(robot(0));
  state.set_withdrawn(0, true);
  state.settle();
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::withdrawn);
  for (const GateRule& rule : state.gate_state(kBridge)) EXPECT_FALSE(rule.pass);
}

TEST(StateTest, NoEndpointOnTheOtherSideMeansNothingToGrant) {
  System system = robot(0);
  system.publishers.clear();
  State state(system);
  const Proposal p = state.propose(one_more_subscriber(1, heart_beat()));
  EXPECT_FALSE(p.fit());
  EXPECT_TRUE(p.verdicts().empty());
}

TEST(StateTest, FindsChannelsByNameAndBySubject) {
  const State state(robot(0));
  EXPECT_EQ(state.find_channel("emergency-switch"), 0U);
  EXPECT_EQ(state.find_channel("0xa4efeccc3210b497"), 0U);
  EXPECT_EQ(state.find_channel("0xA4EFECCC3210B497"), 0U);
  EXPECT_FALSE(state.find_channel("0xa4efeccc3210b498"));
  EXPECT_FALSE(state.find_channel("0xa4efeccc3210b49700"));
  EXPECT_FALSE(state.find_channel("0x"));
  EXPECT_FALSE(state.find_channel(""));
}

}  // namespace
}  // namespace mlcca::core::testing
