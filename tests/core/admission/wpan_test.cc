// SPDX-License-Identifier: BSD-2-Clause
// Networks of IEEE 802.15.4: as Ethernet, with frames that hold little and are never fragmented.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/design/inspect.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/gates/plan.hpp"
#include "core/model/carrier.hpp"
#include "core/model/medium.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::uint32_t kRelay = 990;

Network carrying_subjects(NetworkKind kind) {
  Network n;
  n.name = kind == NetworkKind::ieee802154 ? "air" : "lan";
  n.kind = kind;
  n.profile = Profile::famouso;
  n.provision = can_provision().set(Attribute::max_payload, kWpanBytes);
  return n;
}

/// The switch on 802.15.4, the motors on UDP; a program carries its events.
System from_air() {
  System system = robot(0);
  system.networks[kSecondCan] = carrying_subjects(NetworkKind::ieee802154);
  system.networks[kRobotCan] = carrying_subjects(NetworkKind::udp_multicast);
  system.gateways[kBridge].relay = kRelay;
  return system;
}

void set_payload(System& system, Value bytes) {
  system.publishers[0].attributes.set(Attribute::max_payload, bytes);
  system.subscribers[0].attributes.set(Attribute::max_payload, bytes);
}

const GateRule* rule_at(const GateState& gates, std::size_t port) {
  const auto found = std::ranges::find(gates, port, [](const GateRule& r) { return r.entry.port; });
  return found == gates.end() ? nullptr : &*found;
}

TEST(WpanTest, AnEventThatFillsAFrameIsGrantedUnfragmented) {
  System system = from_air();
  set_payload(system, kWpanBytes);
  system.publishers[0].station = *station_of("0xbeef:0x0001");
  const State state(system);
  ASSERT_TRUE(only_verdict(state).granted);
  const GateState gates = state.gate_state(kBridge);
  const GateRule* const in = rule_at(gates, kSecondCan);
  ASSERT_NE(in, nullptr);
  EXPECT_EQ(in->entry.max_length, 102U);
  EXPECT_FALSE(in->entry.fragmented);
  EXPECT_EQ(in->entry.station, *station_of("0xbeef:0x0001"));
  EXPECT_EQ(in->entry.subject, kEmergency);
  const GateRule* const out = rule_at(gates, kRobotCan);
  ASSERT_NE(out, nullptr);
  EXPECT_TRUE(out->entry.station.is_wildcard()) << "the relay sends from its own address";
  EXPECT_EQ(out->entry.uid, kRelay);
}

TEST(WpanTest, AnEventThatIsLongerIsRefused) {
  System system = from_air();
  set_payload(system, kWpanBytes + 1);
  for (Network& n : system.networks) n.provision.set(Attribute::max_payload, kDatagramMaxEvent);
  const State state(system);
  EXPECT_FALSE(only_verdict(state).granted);
  EXPECT_EQ(only_verdict(state).obstacle, Obstacle::too_long);
  EXPECT_EQ(only_verdict(state).obstacle_at, network(kSecondCan));
  EXPECT_EQ(inspect(system).channels[0].outcome, Outcome::unfit);
  for (const Value bytes : {kWpanBytes, kWpanBytes + 1}) {
    EXPECT_FALSE(is_fragmented(system.networks[kSecondCan], nullptr, bytes));
    EXPECT_EQ(frames_per_event(system.networks[kSecondCan], nullptr, bytes), 1U);
  }
}

TEST(WpanTest, APublisherThatStatesNoSizeMayFillAFrame) {
  System system = from_air();
  system.publishers[0].attributes.clear(Attribute::max_payload);
  system.subscribers[0].attributes.clear(Attribute::max_payload);
  const GateState gates = State(system).gate_state(kBridge);
  const GateRule* const in = rule_at(gates, kSecondCan);
  ASSERT_NE(in, nullptr);
  EXPECT_EQ(in->entry.max_length, 102U);
  EXPECT_FALSE(in->entry.fragmented);
}

TEST(WpanTest, TheKernelCarriesNothingToOrFromIt) {
  System system = from_air();
  const Network& air = system.networks[kSecondCan];
  const Network& lan = system.networks[kRobotCan];
  Gateway& gateway = system.gateways[kBridge];
  gateway.forwarder = Forwarder::can_gw;
  gateway.relay.reset();
  EXPECT_FALSE(are_joined_by_kernel(gateway, air, lan));
  EXPECT_FALSE(are_joined_by_kernel(gateway, lan, air));
  EXPECT_FALSE(are_joined_by_kernel(gateway, air, air));
  EXPECT_TRUE(are_joined_by_kernel(gateway, lan, lan));
  EXPECT_EQ(only_verdict(State(system)).obstacle, Obstacle::no_sender);
}

TEST(WpanTest, SubscriptionsOfNodesAreControlTraffic) {
  const GateState rules = control_rules(from_air(), kBridge, {});
  EXPECT_TRUE(std::ranges::any_of(rules, [](const GateRule& r) {
    return r.entry.port == kSecondCan && r.entry.subject == kSubscribeSubject;
  }));
}

}  // namespace
}  // namespace mlcca::core::testing
