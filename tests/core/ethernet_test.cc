// SPDX-License-Identifier: BSD-2-Clause
// Networks whose frames carry the subject itself: no binding, and a gate of another kind.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/control_traffic.hpp"
#include "core/medium.hpp"
#include "core/plan.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

Network ethernet(const std::string& name) {
  Network n;
  n.name = name;
  n.kind = NetworkKind::udp_multicast;
  n.profile = Profile::famouso;
  n.provision = can_provision().set(Attribute::max_payload, kDatagramMaxEvent);
  return n;
}

/// The switch on the second bus or network, which is Ethernet.
System from_ethernet() {
  System system = robot(0);
  system.networks[kSecondCan] = ethernet("lan");
  system.publishers[0].node = 5;
  return system;
}

TEST(EthernetTest, NeedsNoBindingAndGatesBySubjectAlone) {
  System system = from_ethernet();
  system.networks[kRobotCan] = ethernet("mesh");
  const State state(system);
  ASSERT_TRUE(state.decisions()[0].verdicts[0].granted);
  const GateState gates = state.gate_state(kBridge);
  ASSERT_EQ(gates.size(), 2U);
  for (const GateRule& rule : gates) {
    EXPECT_TRUE(rule.pass);
    EXPECT_EQ(rule.entry.subject, kEmergency);
    EXPECT_EQ(rule.entry.id, 0U);
    EXPECT_EQ(rule.entry.mask, 0U);
    EXPECT_EQ(rule.entry.max_length, 8U);
    EXPECT_FALSE(rule.entry.split);
    EXPECT_FALSE(rule.entry.classic);
  }
}

TEST(EthernetTest, NobodyCarriesEventsFromOneKindToTheOtherUnlessItIsSaid) {
  System system = from_ethernet();
  const State refused(system);
  const Verdict& verdict = refused.decisions()[0].verdicts[0];
  EXPECT_EQ(verdict.obstacle, Obstacle::no_sender);
  EXPECT_EQ(verdict.obstacle_at, gateway(kBridge));
  EXPECT_FALSE(verdict.granted);

  system.gateways[kBridge].ports[kRobotCan].sender = 1000;
  const State state(system);
  ASSERT_TRUE(state.decisions()[0].verdicts[0].granted);
  const GateState gates = state.gate_state(kBridge);
  const auto out = std::ranges::find_if(
      gates, [](const GateRule& r) { return r.entry.direction == Direction::egress; });
  ASSERT_NE(out, gates.end());
  EXPECT_FALSE(out->entry.source_port);
  EXPECT_EQ(out->entry.uid, 1000U);
}

TEST(EthernetTest, ALargeEventMayBeSplit) {
  const Network lan = ethernet("lan");
  EXPECT_FALSE(is_fragmented(lan, nullptr, 8183));
  EXPECT_TRUE(is_fragmented(lan, nullptr, 8184));
  EXPECT_EQ(frames_per_event(lan, nullptr, 0), 1U);
  EXPECT_EQ(frames_per_event(lan, nullptr, 8183), 1U);
  EXPECT_EQ(frames_per_event(lan, nullptr, 8184), 2U);
  EXPECT_EQ(frames_per_event(lan, nullptr, 10'000), 2U);
  EXPECT_EQ(frames_per_event(lan, nullptr, 2 * 8177), 2U);
  EXPECT_EQ(frames_per_event(lan, nullptr, 2 * 8177 + 1), 3U);
  EXPECT_EQ(frames_per_event(lan, nullptr, 65'535), 9U);

  System system = from_ethernet();
  system.networks[kRobotCan] = ethernet("mesh");
  const auto gates_of = [&](Value bytes) {
    system.publishers[0].attributes.set(Attribute::max_payload, bytes);
    for (Network& n : system.networks) n.provision.set(Attribute::bandwidth, 10'000'000);
    return State(system).gate_state(kBridge);
  };
  for (const GateRule& rule : gates_of(8183)) EXPECT_FALSE(rule.entry.split);
  for (const GateRule& rule : gates_of(8184)) {
    EXPECT_TRUE(rule.entry.split);
    EXPECT_EQ(rule.entry.max_length, 8183U);
  }
}

TEST(EthernetTest, TheLargestEventFits) {
  System system = from_ethernet();
  system.networks[kRobotCan] = ethernet("mesh");
  for (Network& n : system.networks)
    n.provision.set(Attribute::max_payload, 100'000).set(Attribute::bandwidth, 100'000'000);
  system.publishers[0].attributes.set(Attribute::max_payload, 65'535);
  EXPECT_EQ(State(system).decisions()[0].verdicts[0].obstacle, Obstacle::none);
  system.publishers[0].attributes.set(Attribute::max_payload, 65'536);
  EXPECT_EQ(State(system).decisions()[0].verdicts[0].obstacle, Obstacle::too_long);
}

TEST(EthernetTest, HasNoControlTrafficOfCan) {
  const System system = from_ethernet();
  for (const GateRule& rule : control_rules(system, kBridge)) EXPECT_EQ(rule.entry.port, kRobotCan);
  EXPECT_FALSE(control_rules(system, kBridge).empty()) << "CAN has some";
}

TEST(EthernetTest, WithoutAProfileNothingIsGated) {
  System system = from_ethernet();
  system.networks[kSecondCan].profile = Profile::none;
  for (const GateRule& rule : State(system).gate_state(kBridge))
    EXPECT_EQ(rule.entry.port, kRobotCan);
}

}  // namespace
}  // namespace mlcca::core::testing
