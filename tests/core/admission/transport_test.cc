// SPDX-License-Identifier: BSD-2-Clause
// Messages of J1939's transport protocol: what of them is granted, and what the gates hold then.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/model/text.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::uint32_t kDm1 = 0xfeca;
constexpr std::uint8_t kEngine = 5;
constexpr Value kSecond = 1000 * kMs;

/// The paper's robot with J1939 buses, and events of 20 bytes each two seconds.
System truck(Value bytes = 20) {
  System system = robot(0);
  for (Network& n : system.networks) {
    n.profile = Profile::j1939;
    n.bus.bitrate = 250'000;
    n.provision = AttributeSet{}.set(Attribute::omission, 0);
    n.bindings[0].id = kDm1;
    n.bindings[0].priority = 6;
  }
  for (Port& port : system.gateways[0].ports) port.queue_length = 100;
  const AttributeSet events = AttributeSet{}
                                  .set(Attribute::period, 2 * kSecond)
                                  .set(Attribute::omission, 0)
                                  .set(Attribute::max_payload, bytes);
  system.channels[0].attributes = events;
  system.publishers[0].attributes = events;
  system.publishers[0].node = kEngine;
  system.subscribers[0].attributes = events;
  return system;
}

std::string why(const State& state) {
  return reason(state.system(), state.members(), only_verdict(state));
}

TEST(TransportTest, ALongMessageIsGrantedWithItsPauses) {
  const State state(truck());
  const Verdict& v = only_verdict(state);
  ASSERT_TRUE(v.granted) << why(state);
  ASSERT_EQ(v.media.size(), 2U);
  EXPECT_GT(v.media[0].response, 600 * kMs) << "three pauses of up to 200 ms";
  EXPECT_LT(v.media[0].response, 610 * kMs);
  EXPECT_LT(v.media[1].response, 20 * kMs) << "the frames are forwarded as they come";
}

TEST(TransportTest, GatesHoldTheMessageAndNotItsFrames) {
  const GateState gates = State(truck()).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 2U);
  for (const GateRule& rule : gates) {
    EXPECT_TRUE(rule.pass);
    EXPECT_TRUE(rule.entry.transport);
    EXPECT_TRUE(rule.entry.classic);
    EXPECT_EQ(rule.entry.id, kExtendedFlag | 0x18feca05);
    EXPECT_EQ(rule.entry.max_length, 20);
    EXPECT_EQ(rule.watching.together, 0U);
  }
  // An event of 20 bytes costs a period: an announcement and three packets.
  const auto in = std::ranges::find(gates, Direction::ingress,
                                    [](const GateRule& r) { return r.entry.direction; });
  EXPECT_NEAR(static_cast<double>(in->policing.per_frame), 5e8, 1e6);
  const GateState in_a_frame = State(truck(8)).gate_state(kBridge);
  for (const GateRule& rule : in_a_frame) {
    EXPECT_FALSE(rule.entry.transport);
    EXPECT_EQ(rule.entry.max_length, 8);
  }
}

TEST(TransportTest, ADeadlineThatThePausesExceedIsRefused) {
  System system = truck();
  system.subscribers[0].attributes.set(Attribute::deadline, 600 * kMs);
  EXPECT_FALSE(only_verdict(State(system)).granted);
  system.subscribers[0].attributes.set(Attribute::deadline, 700 * kMs);
  EXPECT_TRUE(only_verdict(State(system)).granted) << why(State(system));
  system = truck(700);  // 100 packets: 20 s
  EXPECT_FALSE(only_verdict(State(system)).granted);
}

TEST(TransportTest, WhatIsStatedOfABusIsOfFrames) {
  System system = truck();
  for (Network& n : system.networks) {
    n.bus.bitrate = 0;
    n.provision = can_provision();
    n.provision.clear(Attribute::max_payload).set(Attribute::max_payload, 1785);
  }
  const State state(system);
  ASSERT_TRUE(only_verdict(state).granted) << why(state);
  EXPECT_EQ(only_verdict(state).provision[Attribute::latency], (5 + 600 + 2 + 5) * kMs);
  system.networks[1].bus.bitrate = system.networks[0].bus.bitrate = 250'000;
  const State analysed(system);
  ASSERT_TRUE(only_verdict(analysed).granted) << why(analysed);
  EXPECT_EQ(only_verdict(analysed).provision[Attribute::latency], (5 + 600 + 2 + 5) * kMs);
}

TEST(TransportTest, WhatGoesToOneAddressIsNoLongerThanAFrame) {
  System system = truck();
  for (Network& n : system.networks) {
    n.bindings[0].id = 0xef00;
    n.bindings[0].destination = 0x21;
  }
  const State state(system);
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::too_long);
  EXPECT_NE(why(state).find("RTS and CTS, which no gate can judge"), std::string::npos)
      << why(state);
  for (Network& n : system.networks) n.bindings[0].destination = std::nullopt;
  EXPECT_TRUE(only_verdict(State(system)).granted);
  EXPECT_EQ(only_verdict(State(truck(1786))).obstacle, Obstacle::too_long);
}

TEST(TransportTest, CanGwCarriesAMessageToItsOwnPgnOnly) {
  const auto obstacle = [](auto change) {
    System system = truck();
    change(system.networks[kRobotCan].bindings[0]);
    return only_verdict(State(system)).obstacle;
  };
  EXPECT_EQ(obstacle([](Binding&) {}), Obstacle::none);
  EXPECT_EQ(obstacle([](Binding& b) { b.id = 0xfecb; }), Obstacle::renamed);
  EXPECT_EQ(obstacle([](Binding& b) { b.priority = 7; }), Obstacle::renamed);
  EXPECT_EQ(obstacle([](Binding& b) { b.priority = std::nullopt; }), Obstacle::renamed);
  System system = truck();
  system.networks[kRobotCan].bindings[0].id = 0xfecb;
  const State state(system);
  EXPECT_NE(why(state).find("another PGN, priority or frame format on the other side of bridge"),
            std::string::npos)
      << why(state);
  system = truck(8);
  system.networks[kRobotCan].bindings[0].id = 0xfecb;
  EXPECT_TRUE(only_verdict(State(system)).granted) << "in a frame it may";
}

/// A second channel of the same node.
void add_another(System& system) {
  system.channels.push_back(system.channels[0]);
  system.channels[1].name = "another";
  system.channels[1].subject = 2;
  for (Network& n : system.networks) {
    n.bindings.push_back(n.bindings[0]);
    n.bindings[1].channel = 1;
    n.bindings[1].id = 0xfecb;
  }
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second";
  system.publishers[1].channel = 1;
  system.subscribers.push_back(system.subscribers[0]);
  system.subscribers[1].name = "other";
  system.subscribers[1].channel = 1;
}

TEST(TransportTest, MessagesOfOneNodeWaitForEachOther) {
  System system = truck();
  add_another(system);
  const State state(system);
  for (const Decision& d : state.decisions())
    ASSERT_TRUE(d.granted) << reason(state.system(), state.members(), d.verdicts[0]);
  EXPECT_GT(state.decisions()[1].verdicts[0].media.at(0).response, 1200 * kMs);
  system.publishers[1].node = 6;
  const State apart(system);
  for (const Decision& d : apart.decisions())
    EXPECT_LT(d.verdicts[0].media.at(0).response, 700 * kMs);
}

TEST(TransportTest, AnAddressThatTwoSendUnderIsRefusedToTheSecond) {
  System system = truck();
  add_another(system);
  system.publishers[1].place = network(kRobotCan);  // the other bus has that node too
  const State state(system);
  EXPECT_TRUE(state.decisions()[0].granted);
  EXPECT_FALSE(state.decisions()[1].granted);
}

}  // namespace
}  // namespace mlcca::core::testing
