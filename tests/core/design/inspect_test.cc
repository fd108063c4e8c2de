// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/inspect.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/core/design/inspected.hpp"

namespace mlcca::core::testing {
namespace {

Alternative set_of(std::int32_t priority, AttributeSet attributes) {
  return {priority, attributes, {}};
}

// --- what fits ---------------------------------------------------------------------------------

TEST(InspectTest, AFitSystemHasNoFindings) {
  const Inspection result = inspect(described(2));
  EXPECT_EQ(ids_of(result), Ids{});
  ASSERT_EQ(result.channels.size(), 1U);
  EXPECT_EQ(result.channels[0].outcome, Outcome::fit);
  EXPECT_EQ(result.channels[0].deliveries, 1U);
  EXPECT_EQ(result.channels[0].set, 0U);
  ASSERT_EQ(result.networks.size(), 2U);
  // 8 bytes every 50 ms.
  EXPECT_EQ(result.networks[kRobotCan].reserved, 160U);
  EXPECT_EQ(result.networks[kSecondCan].reserved, 160U);
}

TEST(InspectTest, FindingsComeInTheOrderOfTheDescription) {
  System system = described(3);
  system.channels[0].safe_side = SafeSide::deliver;
  system.networks.push_back(can_network("island"));
  system.networks.back().origin = {0, 15};
  EXPECT_EQ(ids_of(inspect(system)),
            (Ids{Id::unsafe_drop, Id::unreachable_network, Id::hop_unfit}));
}

TEST(InspectTest, ReportsProgressEveryThousandChannels) {
  System system = described(0);
  system.channels.resize(2100);
  std::vector<std::size_t> reported;
  static_cast<void>(inspect(system, [&](std::size_t done) { reported.push_back(done); }));
  EXPECT_EQ(reported, (std::vector<std::size_t>{1024, 2048}));
}

// --- who asks ----------------------------------------------------------------------------------

TEST(InspectTest, NamesTheHopTheNumbersAndWhoAsked) {
  System system = described(5);
  system.publishers[0].attributes.clear(Attribute::omission);
  const Inspection result = inspect(system);
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::hop_unfit);
  EXPECT_EQ(f.origin.line, kSubscriberLine);
  EXPECT_EQ(f.channel, 0U);
  EXPECT_EQ(f.publisher, 0U);
  EXPECT_EQ(f.subscriber, 0U);
  ASSERT_TRUE(f.has_place);
  EXPECT_EQ(f.place, gateway(kBridge));
  EXPECT_EQ(f.attribute, "Omission");
  EXPECT_EQ(f.required, "2");
  EXPECT_EQ(f.provided, "5");
  EXPECT_EQ(f.text,
            "switch to motors: Omission 2 required by motors, bridge provides 5 (3 too many)");
  EXPECT_EQ(result.channels[0].outcome, Outcome::unfit);
}

TEST(InspectTest, TheStricterOfTheTwoAsked) {
  System system = described(5);
  system.publishers[0].attributes.set(Attribute::omission, 3);
  system.subscribers[0].attributes.set(Attribute::omission, 4);
  EXPECT_NE(only(inspect(system)).text.find("Omission 3 required by switch"), std::string::npos);
  system.subscribers[0].attributes.set(Attribute::omission, 1);
  EXPECT_NE(only(inspect(system)).text.find("Omission 1 required by motors"), std::string::npos);
}

TEST(InspectTest, EachSubscriberIsJudgedByWhatItAsks) {
  System system = described(5);
  system.publishers[0].attributes.clear(Attribute::omission);
  system.subscribers.push_back(
      subscriber("logger", network(kRobotCan), heart_beat().set(Attribute::omission, 5)));
  const Inspection result = inspect(system);
  EXPECT_EQ(only(result).subscriber, 0U) << "the logger stands it";
  EXPECT_EQ(result.channels[0].deliveries, 1U) << "both sit in one place";
  EXPECT_EQ(result.channels[0].outcome, Outcome::unfit);
}

TEST(InspectTest, WhatIsNotStatedIsNotGiven) {
  System system = described(0);
  system.subscribers[0].attributes.set(Attribute::packet_loss, kPercent);
  const Inspection result = inspect(system);
  // Each network and the gateway; end to end it follows from them.
  EXPECT_EQ(ids_of(result), (Ids{Id::hop_unfit, Id::hop_unfit, Id::hop_unfit}));
  for (const Finding& f : result.findings) {
    EXPECT_EQ(f.provided, "not provided");
    EXPECT_EQ(f.required, "1 %");
  }
}

TEST(InspectTest, ThePublisherIsHeldAgainstWhatTheSubscriberAsks) {
  System system = described(0);
  system.subscribers[0].attributes.set(Attribute::period, 40 * kMs);
  const Inspection result = inspect(system);
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::traffic_mismatch);
  EXPECT_EQ(f.attribute, "Period");
  EXPECT_EQ(f.required, "40 ms");
  EXPECT_EQ(f.provided, "50 ms");
}

TEST(InspectTest, EveryHopMayFitWhereTheRouteDoesNot) {
  System system = described(0);
  // 5 + 2 + 5 = 12 ms.
  system.subscribers[0].attributes.set(Attribute::latency, 12 * kMs);
  EXPECT_EQ(ids_of(inspect(system)), Ids{});
  system.subscribers[0].attributes.set(Attribute::latency, 12 * kMs - 1);
  const Inspection result = inspect(system);
  EXPECT_EQ(only(result).id, Id::route_unfit);
  EXPECT_EQ(only(result).provided, "12 ms");
}

// --- attribute sets ----------------------------------------------------------------------------

/// robot() whose channel, and both ends, also have a set that stands `lower` omissions.
System with_sets(Value omission, Value lower) {
  System system = described(omission);
  auto& channel = system.channels[0];
  channel.priority = 2;
  const auto weaker = heart_beat().set(Attribute::omission, lower);
  channel.lower = {set_of(1, weaker)};
  system.publishers[0].lower = {set_of(1, weaker)};
  system.subscribers[0].lower = {set_of(1, weaker)};
  return system;
}

TEST(InspectTest, ThePreferredSetIsUsedWhereItFits) {
  const Inspection result = inspect(with_sets(2, 10));
  EXPECT_EQ(ids_of(result), Ids{});
  EXPECT_EQ(result.channels[0].set, 0U);
}

TEST(InspectTest, ALowerSetIsUsedAndNoted) {
  const Inspection result = inspect(with_sets(5, 10));
  EXPECT_EQ(only(result).id, Id::lower_set);
  EXPECT_EQ(only(result).text,
            "channel emergency-switch: the attribute set of priority 2 does not fit, that of "
            "priority 1 is used");
  EXPECT_EQ(result.channels[0].set, 1U);
  EXPECT_EQ(result.channels[0].outcome, Outcome::fit);
  EXPECT_EQ(result.networks[kRobotCan].reserved, 160U) << "once, whatever was tried";
}

TEST(InspectTest, WhereNoSetFitsThePreferredOneIsExplained) {
  const Inspection result = inspect(with_sets(5, 4));
  EXPECT_EQ(only(result).id, Id::hop_unfit);
  EXPECT_EQ(only(result).required, "2");
  EXPECT_EQ(result.channels[0].outcome, Outcome::unfit);
  EXPECT_EQ(result.networks[kRobotCan].reserved, 0U);
}

TEST(InspectTest, ALowerSetThatIsDecidedAtRunTimeIsSaidToBeBoth) {
  System system = with_sets(5, 10);
  system.gateways[kBridge].provision.set(Attribute::omission, 5, true);
  const Inspection result = inspect(system);
  EXPECT_EQ(ids_of(result), (Ids{Id::lower_set, Id::run_time}));
  EXPECT_EQ(result.channels[0].outcome, Outcome::run_time);
}

// --- routes ------------------------------------------------------------------------------------

/// robot() with a second way, over a third bus that loses five events in a row.
System with_detour() {
  System system = described(0);
  system.networks.push_back(can_network("detour"));
  system.networks[2].provision.set(Attribute::omission, 5);
  for (const std::size_t n : {kRobotCan, kSecondCan}) {
    Gateway g = system.gateways[kBridge];
    g.name = n == kRobotCan ? "near" : "far";
    g.ports[0].network = n;
    g.ports[1].network = 2;
    system.gateways.push_back(g);
  }
  return system;
}

/// robot-can, near, detour, far, second-can
std::vector<Place> over_detour() {
  return {network(kRobotCan), gateway(1), network(2), gateway(2), network(kSecondCan)};
}

TEST(InspectTest, TheShorterWayIsTakenWhereNoneIsDeclared) {
  EXPECT_EQ(ids_of(inspect(with_detour())), Ids{});
}

TEST(InspectTest, ADeclaredRouteIsTakenAlthoughAShorterOneFits) {
  System system = with_detour();
  auto places = over_detour();
  std::ranges::reverse(places);
  system.routes = {{places, {}}};
  EXPECT_EQ(only(inspect(system)).id, Id::hop_unfit);
  EXPECT_EQ(only(inspect(system)).place, network(2));
}

TEST(InspectTest, ADeclaredRouteHoldsInBothDirections) {
  System system = with_detour();
  system.routes = {{over_detour(), {}}};
  EXPECT_EQ(only(inspect(system)).place, network(2)) << "declared from the subscriber's side";
}

TEST(InspectTest, ADeclaredRouteIsForItsTwoEndsOnly) {
  System system = with_detour();
  system.routes = {{{network(kRobotCan), gateway(1), network(2)}, {}}};
  EXPECT_EQ(ids_of(inspect(system)), Ids{});
}

TEST(InspectTest, WithoutAWayTheTwoNetworksAreNamed) {
  System system = described(0);
  system.gateways[kBridge].ports.pop_back();
  const Inspection result = inspect(system);
  EXPECT_EQ(ids_of(result), (Ids{Id::unreachable_network, Id::no_route}));
  EXPECT_NE(result.findings[1].text.find("no route from second-can to robot-can"),
            std::string::npos)
      << result.findings[1].text;
}

// --- best cases --------------------------------------------------------------------------------

TEST(InspectTest, ABestCaseThatFitsIsANote) {
  System system = described(2);
  system.gateways[kBridge].provision.set(Attribute::omission, 2, true);
  const Inspection result = inspect(system);
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::run_time);
  EXPECT_EQ(info(f.id).severity, Severity::note);
  EXPECT_EQ(f.place, gateway(kBridge));
  EXPECT_EQ(f.text,
            "switch to robot-can over second-can, bridge, robot-can: decided at run time "
            "(Omission 2)");
  EXPECT_EQ(result.channels[0].outcome, Outcome::run_time);
  EXPECT_EQ(result.networks[kRobotCan].reserved, 160U) << "it may come to be granted";
}

TEST(InspectTest, ABestCaseThatDoesNotFitRefutes) {
  System system = described(3);
  system.gateways[kBridge].provision.set(Attribute::omission, 3, true);
  EXPECT_EQ(ids_of(inspect(system)), Ids{Id::hop_unfit});
}

// --- a shared medium ---------------------------------------------------------------------------

TEST(InspectTest, AllChannelsTogetherMustFitANetwork) {
  EXPECT_EQ(ids_of(inspect(heart_beats(3, 480))), Ids{});
  const Inspection result = inspect(heart_beats(3, 479));
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::capacity);
  EXPECT_EQ(f.channel, 2U) << "who comes later is refused";
  EXPECT_EQ(f.place, network(kRobotCan));
  EXPECT_EQ(f.required, "160 B/s");
  EXPECT_EQ(f.provided, "159 B/s");
  EXPECT_EQ(f.text,
            "sender-2 needs 160 B/s on robot-can, where 159 B/s of 479 B/s are left (320 B/s for "
            "other channels)");
  EXPECT_EQ(result.networks[kRobotCan].reserved, 320U);
  EXPECT_EQ(result.networks[kSecondCan].reserved, 320U);
}

TEST(InspectTest, AChannelThatDoesNotFitLeavesItsShareToLaterOnes) {
  System system = heart_beats(3, 320);
  // 8 bytes every 40 ms, 200 bytes/s.
  system.publishers[1].attributes.set(Attribute::period, 40 * kMs);
  const Inspection result = inspect(system);
  EXPECT_EQ(only(result).channel, 1U);
  EXPECT_EQ(result.channels[2].outcome, Outcome::fit);
}

TEST(InspectTest, AStrictListenerOnTheWayClosesItForOthersBehind) {
  System system = with_detour();
  system.networks[2].provision.set(Attribute::omission, 0);
  system.gateways[2].provision.set(Attribute::omission, 5);
  system.routes = {{over_detour(), {}}};
  const auto lenient = heart_beat().set(Attribute::omission, 10);
  system.publishers[0].attributes = lenient;
  system.subscribers = {subscriber("logger", network(kRobotCan), lenient)};
  EXPECT_EQ(ids_of(inspect(system)), Ids{});
  // The other way to the detour, over the bridge and `near`, loses nothing: only the logger's
  // events come over `far`.
  system.subscribers.push_back(subscriber("motors", network(2), heart_beat()));
  const Inspection result = inspect(system);
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::overhearing_unfit);
  EXPECT_EQ(f.place, network(2));
  EXPECT_EQ(f.required, "2");
  EXPECT_EQ(f.provided, "5");
}

// --- completeness ------------------------------------------------------------------------------

TEST(InspectTest, EverySubscriptionNeedsAPublisher) {
  System system = described(0);
  system.publishers.clear();
  system.subscribers.push_back(subscriber("logger", network(kRobotCan), heart_beat()));
  const Inspection result = inspect(system);
  EXPECT_EQ(ids_of(result), (Ids{Id::no_publisher, Id::no_publisher}));
  EXPECT_EQ(result.channels[0].outcome, Outcome::unfit);
}

TEST(InspectTest, WithoutSubscribersIsAWarningAndWithoutUsersANote) {
  System system = described(0);
  system.subscribers.clear();
  EXPECT_EQ(ids_of(inspect(system)), Ids{Id::unused_publisher});
  system.publishers.clear();
  EXPECT_EQ(ids_of(inspect(system)), Ids{Id::unused_channel});
}

TEST(InspectTest, AChannelThatMustArriveShouldCrossNoGate) {
  System system = described(0);
  system.channels[0].safe_side = SafeSide::deliver;
  EXPECT_EQ(only(inspect(system)).id, Id::unsafe_drop);
  EXPECT_NE(only(inspect(system)).text.find("gateway bridge"), std::string::npos);
  system.publishers[0].place = network(kRobotCan);
  EXPECT_EQ(ids_of(inspect(system)), Ids{}) << "all on one network";
  system.channels[0].safe_side = SafeSide::drop;
  system.publishers[0].place = network(kSecondCan);
  EXPECT_EQ(ids_of(inspect(system)), Ids{});
}

TEST(InspectTest, ANetworkOnTheWayMustKnowTheChannel) {
  System system = with_detour();
  system.routes = {{over_detour(), {}}};
  system.networks[2].bindings.clear();
  const Inspection result = inspect(system);
  EXPECT_EQ(only(result).id, Id::unbound);
  EXPECT_EQ(only(result).place, network(2));
}

TEST(InspectTest, WhereCapacityIsSharedTheTrafficMustBeKnown) {
  System system = described(0);
  system.publishers[0].attributes.clear(Attribute::period);
  system.subscribers[0].attributes.clear(Attribute::period);
  EXPECT_EQ(ids_of(inspect(system)), Ids{Id::no_traffic});
  for (Network& n : system.networks) n.provision.clear(Attribute::bandwidth);
  EXPECT_EQ(ids_of(inspect(system)), Ids{}) << "nothing is shared out";
}

TEST(InspectTest, AGatewaysBandwidthIsSharedByAllThatItForwards) {
  System system = described(0);
  system.gateways[kBridge].provision.set(Attribute::bandwidth, 320);  // two heart-beats of 160
  for (std::size_t c = 1; c < 3; ++c) {
    system.channels.push_back(system.channels[0]);
    system.publishers.push_back(system.publishers[0]);
    system.subscribers.push_back(system.subscribers[0]);
    system.publishers[c].channel = system.subscribers[c].channel = c;
    for (Network& n : system.networks) {
      n.bindings.push_back(n.bindings[0]);
      n.bindings[c].channel = c;
    }
  }
  const Inspection result = inspect(system);
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::capacity);
  EXPECT_EQ(f.place, gateway(kBridge));
  EXPECT_EQ(f.channel, 2U);
  EXPECT_TRUE(f.text.contains("0 B/s of 320 B/s are left")) << f.text;
  system.gateways[kBridge].provision.set(Attribute::bandwidth, 480);
  EXPECT_EQ(ids_of(inspect(system)), Ids{});
}

/// A third bus with a publisher of the same channel, joined to the robot's bus by a gateway of its
/// own.
System with_second_sender(std::uint8_t node) {
  System system = described(0);
  system.networks.push_back(can_network("third-can"));
  Gateway other = system.gateways[kBridge];
  other.name = "other";
  other.ports[1].network = 2;
  system.gateways.push_back(other);
  Publisher second = system.publishers[0];
  second.name = "second";
  second.place = network(2);
  second.node = node;
  second.origin.line = kPublisherLine + 1;
  system.publishers.push_back(second);
  return system;
}

TEST(InspectTest, TwoGatewaysMustNotSendTheSameIdentifier) {
  const Inspection result = inspect(with_second_sender(kSwitchNode));
  const Finding& f = only(result);
  EXPECT_EQ(f.id, Id::sender_twice);
  EXPECT_EQ(f.place, network(kRobotCan));
  EXPECT_EQ(f.origin.line, kPublisherLine + 1);
  EXPECT_EQ(ids_of(inspect(with_second_sender(kSwitchNode + 1))), Ids{});
}

TEST(InspectTest, ADeadlineThatFollowsFromThePeriodIsSaidToBeImplied) {
  System system = described(0);
  system.gateways[kBridge].provision.clear(Attribute::latency);
  const Inspection result = inspect(system);
  const auto f = std::ranges::find(result.findings, Id::hop_unfit, &Finding::id);
  ASSERT_NE(f, result.findings.end());
  EXPECT_TRUE(f->text.contains("Deadline 50 ms (implied by the Period)")) << f->text;
  EXPECT_TRUE(f->hint.contains("state Latency of bridge")) << f->hint;
}

TEST(InspectTest, EachBusOfAWayWithoutADataRateIsNamed) {
  System system = described(0);
  for (const std::size_t n : {kRobotCan, kSecondCan}) {
    system.networks[n].bus.bitrate = 500'000;
    system.networks[n].bindings[0].format = FrameFormat::fd;
  }
  const std::string hint = only(inspect(system)).hint;
  EXPECT_TRUE(hint.starts_with("add data-bitrate to the Bus of Network " +
                               system.networks[kSecondCan].name + " and of Network " +
                               system.networks[kRobotCan].name))
      << hint;
}

}  // namespace
}  // namespace mlcca::core::testing
