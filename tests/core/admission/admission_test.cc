// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/admission.hpp"

#include <gtest/gtest.h>

#include "core/model/text.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

AttributeSet lenient() { return heart_beat().set(Attribute::omission, 10); }

std::string why(const State& state, const Verdict& v) {
  return reason(state.system(), state.members(), v);
}

TEST(AdmissionTest, RefusesTheEmergencySwitchBehindABridgeThatLosesTooMuch) {
  const State state(robot(5));
  const Verdict& v = only_verdict(state);
  EXPECT_FALSE(v.granted);
  EXPECT_EQ(why(state, v), "Omission 2 required, bridge provides 5 (3 too many)");
  ASSERT_NE(deciding_row(v), nullptr);
  EXPECT_EQ(deciding_row(v)->comparison.margin(), 3U);
}

TEST(AdmissionTest, AdmitsItBehindABridgeThatIsGoodEnough) {
  const State state(robot(2));
  const Verdict& v = only_verdict(state);
  EXPECT_TRUE(v.granted) << why(state, v);
  EXPECT_EQ(v.route.size(), 3U);
  EXPECT_EQ(worst_case_reaction(v), 3 * 50 * kMs + 12 * kMs + 12 * kMs);
  EXPECT_EQ(reaction(v), "174 ms = (Omission 2 + 1) x Period 50 ms + Latency 12 ms + Jitter 12 ms");
}

TEST(AdmissionTest, RefusesWhenOnlyTheWholeRouteLosesTooMuch) {
  System system = robot(1);
  system.networks[kSecondCan].provision.set(Attribute::omission, 1);
  const State state(system);
  const Verdict& v = only_verdict(state);
  EXPECT_FALSE(v.granted);
  EXPECT_EQ(why(state, v), "Omission 2 required, the route provides 3 (1 too many)");
}

TEST(AdmissionTest, ALenientLoggerDoesNotOpenTheWayThatTheMotorsWereRefused) {
  System system = robot(5);
  system.subscribers.push_back(subscriber("logger", network(kRobotCan), lenient()));
  const State state(system);
  const Verdict& v = only_verdict(state);
  EXPECT_FALSE(v.granted);
  EXPECT_EQ(v.subscribers.size(), 2U);
}

TEST(AdmissionTest, TheLoggerAloneIsAdmitted) {
  System system = robot(5);
  system.subscribers = {subscriber("logger", network(kRobotCan), lenient())};
  system.publishers[0].attributes.set(Attribute::omission, 10);
  const State state(system);
  EXPECT_TRUE(only_verdict(state).granted) << why(state, only_verdict(state));
}

TEST(AdmissionTest, WhatThePublisherAsksJoinsTheUnion) {
  System system = robot(5);
  system.subscribers = {subscriber("logger", network(kRobotCan), lenient())};
  EXPECT_FALSE(only_verdict(State(system)).granted);
}

TEST(AdmissionTest, ChecksStrictListenersOfANetworkThatTheEventCrosses) {
  // switch on second-can -> bridge -> robot-can (strict motors) -> gate -> far-can (lenient logger)
  System system = robot(5);
  system.networks.push_back(can_network("far-can"));
  Gateway gate;
  gate.name = "gate";
  gate.provision = AttributeSet{}.set(Attribute::latency, kMs).set(Attribute::omission, 0);
  gate.ports = system.gateways[0].ports;
  gate.ports[1].network = 2;
  system.gateways.push_back(gate);
  system.publishers[0].attributes.set(Attribute::omission, 10);
  system.subscribers.push_back(subscriber("logger", network(2), lenient()));
  const State state(system);
  const auto& verdicts = state.decisions()[0].verdicts;
  ASSERT_EQ(verdicts.size(), 2U);
  EXPECT_FALSE(verdicts[0].granted);
  EXPECT_FALSE(verdicts[1].granted);
  EXPECT_EQ(
      why(state, verdicts[1]),
      "Omission 2 required, the way to robot-can provides 5 (3 too many), and subscribers there "
      "would receive it");

  System without_motors = system;
  without_motors.subscribers.erase(without_motors.subscribers.begin());
  EXPECT_TRUE(only_verdict(State(without_motors)).granted);
}

TEST(AdmissionTest, AMissingProvisionIsARefusal) {
  System system = robot(1);
  system.networks[kRobotCan].provision.clear(Attribute::omission);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(why(state, only_verdict(state)), "Omission 2 required, robot-can provides none");
}

TEST(AdmissionTest, ABestCaseNeverGrants) {
  System system = robot(0);
  system.networks[kRobotCan].provision.set(Attribute::omission, 0, true);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(
      why(state, only_verdict(state)),
      "Omission 2 required, robot-can provides 0 at best, decided at run time and not known now");
}

TEST(AdmissionTest, AGatewayThatSaysNothingAboutOmissionIsARefusal) {
  System system = robot(0);
  system.gateways[0].provision.clear(Attribute::omission);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
}

TEST(AdmissionTest, AGatewayThatSaysNothingAboutLatencyIsARefusal) {
  System system = robot(0);
  system.gateways[0].provision.clear(Attribute::latency);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
}

TEST(AdmissionTest, HoldsPeriodicTrafficAgainstTheComposedLatency) {
  System system = robot(0);
  system.gateways[0].provision.set(Attribute::latency, 40 * kMs);
  EXPECT_TRUE(only_verdict(State(system)).granted);
  system.gateways[0].provision.set(Attribute::latency, 40 * kMs + 1);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(why(state, only_verdict(state)),
            "Deadline 50 ms required, the route provides 50.000001 ms (1 ns too long)");
}

TEST(AdmissionTest, RefusesASlowerPublisherThanTheSubscriberNeeds) {
  System system = robot(0);
  system.publishers[0].attributes.set(Attribute::period, 50 * kMs + 1);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
}

TEST(AdmissionTest, ReservesAndRefusesWhatDoesNotFitAnyMore) {
  System system = robot(0);  // 8 bytes every 50 ms: 160 bytes/s
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, 320);
  for (int i = 1; i < 3; ++i) {
    EventChannel channel = system.channels[0];
    channel.name = "other-" + std::to_string(i);
    channel.subject += static_cast<Subject>(i);
    system.channels.push_back(channel);
    Publisher p = system.publishers[0];
    p.channel = static_cast<std::size_t>(i);
    system.publishers.push_back(p);
    Subscriber s = system.subscribers[0];
    s.channel = static_cast<std::size_t>(i);
    system.subscribers.push_back(s);
    for (Network& n : system.networks) {
      Binding b = n.bindings[0];
      b.channel = static_cast<std::size_t>(i);
      b.id += static_cast<std::uint32_t>(i);
      n.bindings.push_back(b);
    }
  }
  const State state(system);
  EXPECT_TRUE(state.decisions()[0].verdicts[0].granted);
  EXPECT_TRUE(state.decisions()[1].verdicts[0].granted);
  const Verdict& last = state.decisions()[2].verdicts[0];
  EXPECT_FALSE(last.granted);
  EXPECT_EQ(why(state, last),
            "160 B/s needed on robot-can, 0 B/s left (320 B/s promised to others)");
  EXPECT_EQ(state.ledger().reserved(kRobotCan), 320U);
  EXPECT_EQ(state.ledger().reserved(kSecondCan), 320U);
}

TEST(AdmissionTest, CountsABroadcastOnceHoweverManyListen) {
  System system = robot(0);
  system.subscribers.push_back(subscriber("logger", network(kRobotCan), lenient()));
  system.subscribers.push_back(subscriber("app", gateway(kBridge), heart_beat()));
  const State state(system);
  EXPECT_EQ(state.ledger().reserved(kSecondCan), 160U);
}

TEST(AdmissionTest, RefusesUnknownTrafficWhereTheCapacityIsShared) {
  System system = robot(0);
  system.publishers[0].attributes.clear(Attribute::max_payload);
  const State state(system);
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::no_traffic);
}

TEST(AdmissionTest, RefusesAnInterfaceThatIsNotUsableAndGivesBackWhenItIs) {
  State state(robot(0));
  ASSERT_TRUE(only_verdict(state).granted);
  state.set_condition(0, {false, "can0 is down", {}, 0, {}, {}});
  const auto lost = state.settle();
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_TRUE(lost[0].before.all_granted());
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(reason(state.system(), state.members(), only_verdict(state), "can0 is down"),
            "robot-can is not available: can0 is down");
  state.set_condition(0, {});
  EXPECT_EQ(state.settle().size(), 1U);
  state.set_condition(0, {});
  EXPECT_TRUE(state.settle().empty()) << "nothing has changed";
  EXPECT_TRUE(only_verdict(state).granted);
}

TEST(AdmissionTest, NamesWhatStandsInTheWay) {
  System unbound = robot(0);
  unbound.networks[kRobotCan].bindings.clear();
  EXPECT_EQ(only_verdict(State(unbound)).obstacle, Obstacle::unbound);

  System no_node = robot(0);
  no_node.publishers[0].node.reset();
  EXPECT_EQ(only_verdict(State(no_node)).obstacle, Obstacle::no_node);

  System apart = robot(0);
  apart.gateways.clear();
  EXPECT_EQ(only_verdict(State(apart)).obstacle, Obstacle::no_route);

  System raw = robot(0);
  raw.networks[kRobotCan].profile = Profile::raw;
  raw.publishers[0].attributes.set(Attribute::max_payload, 9);
  for (Network& n : raw.networks) n.provision.set(Attribute::max_payload, 4096);
  EXPECT_EQ(only_verdict(State(raw)).obstacle, Obstacle::too_long);
}

TEST(AdmissionTest, TakesAnotherRouteWhenTheShortestIsUnfit) {
  System system = robot(5);
  Gateway second = system.gateways[0];
  second.name = "good-bridge";
  second.provision.set(Attribute::omission, 1);
  system.gateways.push_back(second);
  const State state(system);
  ASSERT_TRUE(only_verdict(state).granted);
  EXPECT_EQ(only_verdict(state).route[1], gateway(1));
}

TEST(AdmissionTest, SplitEventsMakeEveryFrameLossAnEventLoss) {
  System system = robot(0);
  system.publishers[0].attributes.set(Attribute::max_payload, 14);  // two FAMOUSO fragments
  system.subscribers[0].attributes.set(Attribute::max_payload, 14);
  for (Network& n : system.networks) n.provision.set(Attribute::max_payload, 24608);
  EXPECT_TRUE(only_verdict(State(system)).granted);
  system.networks[kRobotCan].provision.set(Attribute::omission, 1);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(why(state, only_verdict(state)),
            "Omission 2 required, robot-can provides unbounded (unbounded)");
}

TEST(AdmissionTest, AddsTheJitterOfTheSourceToThatOfTheRoute) {
  System system = robot(0);
  for (Network& n : system.networks) n.provision.set(Attribute::jitter, kMs);
  system.gateways[0].provision.set(Attribute::jitter, kMs);
  system.publishers[0].attributes.set(Attribute::jitter, 2 * kMs);
  system.subscribers[0].attributes.set(Attribute::jitter, 5 * kMs);
  EXPECT_TRUE(only_verdict(State(system)).granted);
  system.publishers[0].attributes.set(Attribute::jitter, 2 * kMs + 1);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(why(state, only_verdict(state)),
            "Jitter 5 ms required, the route provides 5.000001 ms (1 ns too long)");
}

}  // namespace
}  // namespace mlcca::core::testing
