// SPDX-License-Identifier: BSD-2-Clause
// One publisher, several ways into a network: who receives it there, what it costs, who sends it.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/admission/state.hpp"
#include "core/model/medium.hpp"
#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::size_t kSlow = kBridge;
constexpr std::size_t kFast = 1;
constexpr std::size_t kBehind = 2;  // a gateway with a port on the robot's bus
constexpr std::size_t kFar = 2;     // a bus behind it

AttributeSet lenient() { return heart_beat().set(Attribute::omission, 20); }

Gateway joining(const std::string& name, std::vector<std::size_t> networks, Value omission) {
  Gateway g;
  g.name = name;
  g.provision = AttributeSet{}.set(Attribute::latency, 2 * kMs).set(Attribute::omission, omission);
  for (const std::size_t n : networks) g.ports.emplace_back().network = n;
  return g;
}

/// From the second bus to the robot's by a slow gateway, which is described first, and a fast one.
System two_ways(Value slow_omission) {
  System system = described(slow_omission);
  system.networks.push_back(can_network("far-can"));
  system.publishers[0].attributes = lenient();
  system.gateways.push_back(joining("fast", {kRobotCan, kSecondCan}, 0));
  system.gateways.push_back(joining("behind", {kRobotCan, kFar}, 0));
  return system;
}

const Verdict& towards(const State& state, Place place) {
  return *std::ranges::find(state.decisions()[0].verdicts, place, &Verdict::to);
}

bool passes(const Verdict& v, std::size_t g) {
  return std::ranges::find(v.route, gateway(g)) != v.route.end();
}

TEST(WayInTest, AStrictListenerOnTheLastNetworkBeforeAProgramIsHeeded) {
  System system = two_ways(10);
  system.subscribers.push_back(subscriber("program", gateway(kBehind), lenient()));
  const State state(std::move(system));
  EXPECT_TRUE(towards(state, gateway(kBehind)).granted);
  EXPECT_TRUE(passes(towards(state, gateway(kBehind)), kFast));
  EXPECT_TRUE(passes(towards(state, network(kRobotCan)), kFast));
}

TEST(WayInTest, AStrictProgramReceivesFromTheNetworkOfItsGateway) {
  System system = two_ways(10);
  system.subscribers = {subscriber("far", network(kFar), lenient())};
  system.gateways.push_back(joining("listening", {kRobotCan}, 0));
  const State alone(system);
  EXPECT_TRUE(passes(towards(alone, network(kFar)), kSlow)) << "no other subscriber is there";
  system.subscribers.push_back(subscriber("program", gateway(3), heart_beat()));
  const State both(std::move(system));
  EXPECT_TRUE(towards(both, network(kFar)).granted);
  EXPECT_TRUE(passes(towards(both, network(kFar)), kFast));
}

/// To the robot's bus over the fast gateway, to the far one over the slow one and the robot's bus.
System entering_twice(Value capacity) {
  System system = two_ways(0);
  system.subscribers.push_back(subscriber("far", network(kFar), lenient()));
  system.networks[kRobotCan].provision.set(Attribute::bandwidth, capacity);
  system.routes = {
      {{network(kSecondCan), gateway(kFast), network(kRobotCan)}, {}},
      {{network(kSecondCan), gateway(kSlow), network(kRobotCan), gateway(kBehind), network(kFar)},
       {}}};
  return system;
}

TEST(WayInTest, EventsThatEnterANetworkTwiceTakeItsCapacityTwice) {
  const auto entering = [](Value capacity) {
    System system = entering_twice(capacity);
    for (Network& n : system.networks) {
      n.kind = NetworkKind::other;
      n.profile = Profile::none;
    }
    return system;
  };
  const State enough(entering(320));  // two heart-beats of 160 B/s
  EXPECT_TRUE(std::ranges::all_of(enough.decisions()[0].verdicts, &Verdict::granted));
  EXPECT_EQ(enough.ledger().reserved(kRobotCan), 320U);
  EXPECT_EQ(enough.ledger().reserved(kSecondCan), 160U) << "sent once";
  const State short_by_one(entering(319));
  EXPECT_EQ(std::ranges::count_if(short_by_one.decisions()[0].verdicts, &Verdict::granted), 1);
}

TEST(WayInTest, OfTwoGatewaysThatWouldSendOneIdentifierToABusTheSecondIsRefused) {
  const State state(entering_twice(320));
  EXPECT_TRUE(towards(state, network(kRobotCan)).granted);
  const Verdict& twice = towards(state, network(kFar));
  EXPECT_FALSE(twice.granted);
  EXPECT_EQ(twice.obstacle, Obstacle::sender_twice);
  EXPECT_EQ(twice.obstacle_at, network(kRobotCan));
  EXPECT_EQ(state.ledger().reserved(kRobotCan), 160U);
}

TEST(WayInTest, ASecondSenderOfOneIdentifierIsAvoidedByAnotherWay) {
  System system = entering_twice(320);
  system.routes.push_back(
      {{network(kSecondCan), gateway(kFast), network(kRobotCan), gateway(kBehind), network(kFar)},
       {}});
  const State state(std::move(system));
  EXPECT_TRUE(towards(state, network(kRobotCan)).granted);
  EXPECT_TRUE(towards(state, network(kFar)).granted);
  EXPECT_TRUE(passes(towards(state, network(kFar)), kFast));
}

TEST(WayInTest, APublisherOnABusAndAGatewayDoNotBothSendOneIdentifierThere) {
  System system = two_ways(0);
  Publisher own = system.publishers[0];
  own.name = "own";
  own.place = network(kRobotCan);
  system.publishers.push_back(own);
  const State state(std::move(system));
  const auto& verdicts = state.decisions()[0].verdicts;
  ASSERT_EQ(verdicts.size(), 2U);
  EXPECT_TRUE(verdicts[0].granted);
  EXPECT_FALSE(verdicts[1].granted);
  EXPECT_EQ(verdicts[1].obstacle, Obstacle::sender_twice);
}

TEST(WayInTest, TwoGatewaysSendTheEventsOfOnePublisherUnderOneIdentifier) {
  const Inspection result = inspect(entering_twice(320));
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::sender_twice);
  EXPECT_TRUE(f.has_place);
  EXPECT_EQ(f.place, network(kRobotCan));
}

TEST(WayInTest, AnEventTooLongForFamousoIsNoticedOnEveryNetworkOfItsWay) {
  System system = robot(0);
  system.networks[kSecondCan].kind = NetworkKind::other;
  system.networks[kSecondCan].profile = Profile::none;
  for (Network& n : system.networks) n.provision = {};
  system.gateways[kBridge].provision = {};
  system.publishers[0].attributes =
      AttributeSet{}.set(Attribute::max_payload, kFamousoMaxEvent + 1);
  system.subscribers[0].attributes = {};
  EXPECT_EQ(only_verdict(State(system)).obstacle, Obstacle::too_long);
  system.publishers[0].attributes.set(Attribute::max_payload, kFamousoMaxEvent);
  EXPECT_EQ(only_verdict(State(system)).obstacle, Obstacle::none);
}

}  // namespace
}  // namespace mlcca::core::testing
