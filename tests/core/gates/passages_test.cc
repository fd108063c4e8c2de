// SPDX-License-Identifier: BSD-2-Clause
// How granted events enter a gateway and leave it, and who carries them in between.
#include <gtest/gtest.h>

#include "core/gates/plan.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::uint32_t kRelay = 990;

/// The second network is Ethernet, or both are; mlcca-relay is there.
System with_ethernet(bool both) {
  System system = robot(0);
  for (const std::size_t n : {kSecondCan, kRobotCan}) {
    if (n == kRobotCan && !both) continue;
    system.networks[n].kind = NetworkKind::udp_multicast;
    system.networks[n].bindings.clear();
  }
  system.publishers[0].node = 5;
  system.publishers[0].station = *station_of("192.0.2.7");
  system.gateways[kBridge].relay = kRelay;
  return system;
}

std::vector<Passage> passages_of(const State& state) {
  return passages(state.system(), state.members(), 0, state.decisions()[0].verdicts, kBridge);
}

const GateRule* leaving(const GateState& gates) {
  for (const GateRule& rule : gates)
    if (rule.entry.direction == Direction::egress) return &rule;
  return nullptr;
}

TEST(PassagesTest, TheRelayCarriesFromEthernetToABusUnlessItIsLeftToOthers) {
  System system = with_ethernet(false);
  const State state(system);
  ASSERT_TRUE(state.decisions()[0].verdicts[0].granted);
  const auto found = passages_of(state);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].by_kernel);
  EXPECT_EQ(found[0].in->station, *station_of("192.0.2.7"));
  EXPECT_EQ(found[0].out->uid, kRelay);
  EXPECT_NE(found[0].out->id & kEtag, 0U);

  system.gateways[kBridge].forwarder = Forwarder::can_gw;
  EXPECT_EQ(State(system).decisions()[0].verdicts[0].obstacle, Obstacle::no_sender);
  system.gateways[kBridge].ports[kRobotCan].sender = 1000;
  EXPECT_EQ(passages_of(State(system))[0].out->uid, 1000U);
  system.gateways[kBridge].forwarder = Forwarder::relay;
  EXPECT_EQ(passages_of(State(system))[0].out->uid, 1000U) << "a sender goes before the relay";
}

TEST(PassagesTest, WithoutItsUserTheRelayIsGrantedNothing) {
  System system = with_ethernet(true);
  system.gateways[kBridge].relay.reset();
  const State state(system);
  EXPECT_EQ(state.decisions()[0].verdicts[0].obstacle, Obstacle::no_sender);
  EXPECT_TRUE(passages_of(state).empty());
}

TEST(PassagesTest, BetweenEthernetNetworksTheRelaySendsFromItsOwnAddress) {
  System system = with_ethernet(true);
  const State relayed(system);
  const auto found = passages_of(relayed);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].by_kernel);
  EXPECT_EQ(found[0].in->station, *station_of("192.0.2.7"));
  EXPECT_TRUE(found[0].out->station.is_wildcard());
  EXPECT_EQ(leaving(relayed.gate_state(kBridge))->entry, *found[0].out);
  EXPECT_FALSE(leaving(relayed.gate_state(kBridge))->entry.source_port);

  system.gateways[kBridge].forwarder = Forwarder::can_gw;
  const State bridged(system);
  const auto by_kernel = passages_of(bridged);
  ASSERT_EQ(by_kernel.size(), 1U);
  EXPECT_TRUE(by_kernel[0].by_kernel);
  EXPECT_EQ(by_kernel[0].out->source_port, kSecondCan);
  EXPECT_EQ(by_kernel[0].out->station, *station_of("192.0.2.7"));
}

TEST(PassagesTest, BehindARelayAnotherGatewaySeesTheAddressOfTheRelay) {
  // second - bridge - robot - second bridge - far, all Ethernet.
  System system = with_ethernet(true);
  system.networks.push_back(system.networks[kRobotCan]);
  system.networks[2].name = "far";
  system.subscribers.resize(1);
  system.subscribers[0].place = network(2);
  Gateway second = system.gateways[kBridge];
  second.name = "second bridge";
  second.ports[0].network = kRobotCan;
  second.ports[1].network = 2;
  system.gateways.push_back(second);
  const State state(system);
  ASSERT_TRUE(state.decisions()[0].verdicts[0].granted);
  for (const GateRule& rule : state.gate_state(1))
    EXPECT_TRUE(rule.entry.station.is_wildcard()) << to_text(rule.entry.direction);
}

TEST(PassagesTest, ProgramsOnTheGatewayAreEndsWithoutANetwork) {
  System here = robot(0);
  here.publishers[0].place = {Place::Kind::gateway, kBridge};
  here.publishers[0].uid = 1000;
  const auto out = passages_of(State(here));
  ASSERT_EQ(out.size(), 1U);
  EXPECT_FALSE(out[0].in);
  EXPECT_EQ(out[0].out->uid, 1000U);

  System there = robot(0);
  there.subscribers.resize(1);
  there.subscribers[0].place = {Place::Kind::gateway, kBridge};
  const auto in = passages_of(State(there));
  ASSERT_EQ(in.size(), 1U);
  EXPECT_EQ(in[0].in->port, kSecondCan);
  EXPECT_FALSE(in[0].out);

  there.publishers[0] = here.publishers[0];
  const auto local = passages_of(State(there));
  ASSERT_EQ(local.size(), 1U);
  EXPECT_FALSE(local[0].in || local[0].out);
}

TEST(PassagesTest, WhatIsRefusedHasNone) { EXPECT_TRUE(passages_of(State(robot(5))).empty()); }

}  // namespace
}  // namespace mlcca::core::testing
