// SPDX-License-Identifier: BSD-2-Clause
#include "core/gates/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

constexpr std::uint32_t kId = 0x1f400000U | (std::uint32_t{kSwitchNode} << 14) | kEtag;
constexpr std::uint32_t kAllBits = 0x1fffffff;

const GateRule* find(const GateState& state, std::size_t port, Direction direction) {
  const auto it = std::ranges::find_if(state, [&](const GateRule& r) {
    return r.entry.port == port && r.entry.direction == direction;
  });
  return it == state.end() ? nullptr : &*it;
}

TEST(PlanTest, OpensTheWayInAndTheWayOutForExactlyWhatWasGranted) {
  const GateState gates = State(robot(0)).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 2U);
  const GateRule* in = find(gates, kSecondCan, Direction::ingress);
  const GateRule* out = find(gates, kRobotCan, Direction::egress);
  ASSERT_NE(in, nullptr);
  ASSERT_NE(out, nullptr);
  for (const GateRule* rule : {in, out}) {
    EXPECT_TRUE(rule->pass);
    EXPECT_EQ(rule->entry.id, kExtendedFlag | kId);
    EXPECT_EQ(rule->entry.mask, kExtendedFlag | kRemoteFlag | kAllBits);
    EXPECT_EQ(rule->entry.max_length, 8);
    EXPECT_TRUE(rule->entry.classic);
    EXPECT_FALSE(rule->entry.fd);
    EXPECT_EQ(rule->entry.subject, kEmergency);
  }
  EXPECT_EQ(out->entry.source_port, kSecondCan);
  EXPECT_EQ(out->entry.entered_as, (FrameIdentity{in->entry.id, in->entry.mask}));
  EXPECT_EQ(in->entry.entered_as, FrameIdentity{});
}

TEST(PlanTest, KnowsARefusedSubjectAndDeniesIt) {
  const GateState gates = State(robot(5)).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 2U);
  for (const GateRule& rule : gates) EXPECT_FALSE(rule.pass);
}

TEST(PlanTest, NeedsNothingForAChannelThatStaysOnItsBus) {
  System system = robot(0);
  system.publishers[0].place = network(kRobotCan);
  const GateState gates = State(system).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 1U);
  EXPECT_EQ(gates[0].entry.direction, Direction::ingress);
  EXPECT_FALSE(gates[0].pass);
}

TEST(PlanTest, ALocalProgramMaySendOnlyAsItsUser) {
  System system = robot(0);
  system.publishers[0].place = gateway(kBridge);
  EXPECT_TRUE(State(system).gate_state(kBridge).empty());
  system.publishers[0].uid = 1000;
  const GateState gates = State(system).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 1U);
  EXPECT_EQ(gates[0].entry.direction, Direction::egress);
  EXPECT_EQ(gates[0].entry.port, kRobotCan);
  EXPECT_FALSE(gates[0].entry.source_port);
  EXPECT_EQ(gates[0].entry.uid, 1000U);
}

TEST(PlanTest, AGateOfABusDistinguishesSixteenPublishersOfASubject) {
  System system = robot(0);
  const auto add = [&system] {
    Publisher p = system.publishers.back();
    p.name = "switch-" + std::to_string(system.publishers.size());
    p.node = static_cast<std::uint8_t>(*p.node + 1);
    system.publishers.push_back(p);
  };
  while (system.publishers.size() < kMostBusEntries) add();
  EXPECT_EQ(State(system).exceeds_capacity(kBridge), std::nullopt);
  add();
  EXPECT_TRUE(State(system).exceeds_capacity(kBridge).value_or("").starts_with(
      "channel emergency-switch: more than 16 publishers of it "));
}

TEST(PlanTest, PublishersThatCannotBeDistinguishedPassOnlyIfAllMay) {
  System system = robot(0);
  for (Network& n : system.networks) {
    n.profile = Profile::raw;
    n.bindings[0].id = 0x123;
    n.bindings[0].extended = false;
  }
  system.publishers[0].node.reset();
  Publisher slow = system.publishers[0];
  slow.name = "slow";
  slow.attributes.set(Attribute::period, 51 * kMs);
  EXPECT_TRUE(find(State(system).gate_state(kBridge), kRobotCan, Direction::egress)->pass);
  system.publishers.push_back(slow);
  const GateState gates = State(system).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 2U);
  for (const GateRule& rule : gates) EXPECT_FALSE(rule.pass);
}

TEST(PlanTest, RawIdentifiersAreMatchedInTheirForm) {
  System system = robot(0);
  for (Network& n : system.networks) n.profile = Profile::raw;
  system.publishers[0].node.reset();
  for (const bool extended : {false, true}) {
    for (Network& n : system.networks) {
      n.bindings[0].id = 0x123;
      n.bindings[0].extended = extended;
      n.bindings[0].remote_frames = extended;
      n.bindings[0].format = extended ? FrameFormat::any : FrameFormat::fd;
    }
    const GateEntry e = State(system).gate_state(kBridge).at(0).entry;
    EXPECT_EQ(e.id, extended ? 0x80000123U : 0x123U);
    EXPECT_EQ(e.mask, extended ? 0x9fffffffU : 0xdfffffffU);
    EXPECT_EQ(e.classic, extended);
    EXPECT_TRUE(e.fd);
    EXPECT_EQ(e.max_length, 8);
  }
}

TEST(PlanTest, SplitEventsMayCarryTheFragmentBit) {
  System system = robot(0);
  system.publishers[0].attributes.set(Attribute::max_payload, 9);
  for (Network& n : system.networks) n.provision.set(Attribute::max_payload, 100);
  system.subscribers[0].attributes.set(Attribute::max_payload, 9);
  const GateEntry e = State(system).gate_state(kBridge).at(0).entry;
  EXPECT_EQ(e.mask, (kExtendedFlag | kRemoteFlag | kAllBits) & ~(1U << 21));
}

TEST(PlanTest, ADeliveryHasTheSlotsOfItsOwnPublisherOnly) {
  System system = robot(0);
  Publisher other = system.publishers[0];
  other.name = "other";
  other.node = 0x21;
  system.publishers.push_back(other);
  const State state(std::move(system));
  EXPECT_EQ(state.gate_state(kBridge).size(), 4U);
  for (const Verdict& v : state.decisions()[0].verdicts) {
    const GateState own = gate_state(state.system(), state.members(), v, kBridge);
    ASSERT_EQ(own.size(), 2U);
    for (const GateRule& rule : own)
      EXPECT_EQ(rule.entry.id >> 14 & 0x7fU, *state.members().publisher(v.publisher).node);
  }
}

TEST(PlanTest, TheDifferenceLeavesAloneWhatStays) {
  GateState a = State(robot(0)).gate_state(kBridge);
  GateState b = a;
  EXPECT_TRUE(gate_changes_between(a, b).empty());
  b[0].pass = false;
  EXPECT_EQ(gate_changes_between(a, b), (GateChanges{{a[0].entry}, {}, {}, {}, {}}));
  EXPECT_EQ(gate_changes_between(b, a), (GateChanges{{}, {}, {}, {a[0].entry}, {}}));
  EXPECT_EQ(gate_changes_between({}, a), (GateChanges{{}, {}, a, {}, {}}));
  EXPECT_EQ(gate_changes_between(a, {}), (GateChanges{{}, {a[0].entry, a[1].entry}, {}, {}, {}}));
}

TEST(PlanTest, AnotherRateIsAChangeOfItsOwn) {
  const GateState a = State(robot(0)).gate_state(kBridge);
  GateState b = a;
  b[1].policing.per_frame += 1;
  EXPECT_EQ(gate_changes_between(a, b), (GateChanges{{}, {}, {}, {}, {b[1]}}));
}

TEST(PlanTest, WhatIsExpectedIsAChangeOfItsOwn) {
  const GateState a = State(robot(0)).gate_state(kBridge);
  GateState b = a;
  b[1].watching.silence += 1;
  EXPECT_EQ(gate_changes_between(a, b), (GateChanges{{}, {}, {}, {}, {b[1]}}));
}

/// Of the slot that the switch's events enter by.
Watching expected(const System& system) {
  return find(State(system).gate_state(kBridge), kSecondCan, Direction::ingress)->watching;
}

TEST(PlanTest, AHeartBeatIsWatchedWhereItComesIn) {
  const GateState rules = State(robot(0)).gate_state(kBridge);
  EXPECT_EQ(find(rules, kRobotCan, Direction::egress)->watching, Watching{});
  const Watching w = expected(robot(0));
  EXPECT_EQ(w.period, 50 * kMs);
  EXPECT_EQ(w.silence, 3 * 50'025'000U + 12 * kMs)
      << "(Omission + 1) * Period, 500 ppm slower, and the Jitter: at most the Latency";
  EXPECT_EQ(w.together, 0U);
}

TEST(PlanTest, TheStrictestSubscriberSaysHowLongSilenceMayLast) {
  System system = robot(0);
  system.subscribers[0].attributes.set(Attribute::omission, 0);
  EXPECT_EQ(expected(system).silence, 50'025'000U + 12 * kMs);
}

TEST(PlanTest, WhatIsRefusedOrRequiresNoOmissionHasNoSilenceTimer) {
  EXPECT_EQ(expected(robot(5)).silence, 0U) << "refused";
  EXPECT_EQ(expected(robot(5)).period, 50 * kMs);
  System system = robot(0);
  system.channels[0].attributes.clear(Attribute::omission);
  system.publishers[0].attributes.clear(Attribute::omission);
  system.subscribers[0].attributes.clear(Attribute::omission);
  EXPECT_EQ(expected(system).silence, 0U);
}

TEST(PlanTest, SporadicEventsAreNotWatchedAndAreLimitedAsOthersAre) {
  System system = robot(0);
  const auto before = State(system).gate_state(kBridge);
  system.channels[0].arrival = Arrival::sporadic;
  const State state(system);
  EXPECT_EQ(find(state.gate_state(kBridge), kSecondCan, Direction::ingress)->watching, Watching{});
  EXPECT_EQ(find(state.gate_state(kBridge), kSecondCan, Direction::ingress)->policing,
            find(before, kSecondCan, Direction::ingress)->policing);
  for (const Verdict& v : state.decisions()[0].verdicts) {
    EXPECT_TRUE(v.granted);
    EXPECT_EQ(silence_of(v), 0U);
    EXPECT_EQ(silence_here(v), 0U);
    EXPECT_EQ(worst_case_reaction(v), std::nullopt);
  }
}

TEST(PlanTest, FramesOfAnEventAreExpectedTogether) {
  System system = robot(0);
  system.publishers[0].attributes.set(Attribute::max_payload, 9);
  system.subscribers[0].attributes.set(Attribute::max_payload, 9);
  for (Network& n : system.networks) n.provision.set(Attribute::max_payload, 100);
  EXPECT_EQ(expected(system).together, 25 * kMs);
}

/// Two alike, and what the gate expects of them.
TEST(PlanTest, OfPublishersThatCannotBeDistinguishedItIsSeenThatNoneSends) {
  System system = robot(0);
  for (Network& n : system.networks) {
    n.profile = Profile::raw;
    n.bindings[0].id = 0x123;
    n.bindings[0].extended = false;
  }
  system.publishers[0].node.reset();
  const Watching alone = expected(system);
  EXPECT_NE(alone, Watching{});
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "other";
  EXPECT_EQ(expected(system), alone) << "either of them ends the silence";
  system.publishers[1].attributes.set(Attribute::period, 40 * kMs);
  EXPECT_EQ(expected(system), alone) << "the slower one's";
  system.publishers[1].attributes.clear(Attribute::period);
  system.publishers[1].attributes.set(Attribute::bandwidth, 100);
  const State unfit(system);
  EXPECT_EQ(find(unfit.gate_state(kBridge), kSecondCan, Direction::ingress)->watching, Watching{})
      << "nothing passes, nothing can be missing";
}

/// A first frame of the one may be taken for a later frame of the other's event.
TEST(PlanTest, FramesOfTwoThatLookAlikeMayCountAsOneEvent) {
  System system = robot(0);
  system.publishers[0].attributes.set(Attribute::max_payload, 9);
  system.subscribers[0].attributes.set(Attribute::max_payload, 9);
  for (Network& n : system.networks) n.provision.set(Attribute::max_payload, 100);
  const Watching alone = expected(system);
  ASSERT_EQ(alone.together, 25 * kMs);
  ASSERT_NE(alone.silence, 0U);
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "other";
  EXPECT_EQ(expected(system), (Watching{alone.period, alone.silence + 25 * kMs, 25 * kMs}));
}

constexpr Value kMillisecond = 1'000'000;

TEST(PlanTest, APeriodicPublisherIsPolicedByItsPeriod) {
  AttributeSet said;
  said.set(Attribute::period, 2 * kMillisecond).set(Attribute::jitter, 5);
  const Policing one = policing_of(said, 1);
  EXPECT_EQ(one.per_frame, 1'999'000U) << "500 ppm faster: clocks differ";
  EXPECT_EQ(one.tolerance, 1'999'000U + 5) << "one event early, and its jitter";
  EXPECT_EQ(one.per_byte, 0U);
  const Policing four = policing_of(said, 4);
  EXPECT_EQ(four.per_frame, 499'750U);
  EXPECT_EQ(four.tolerance, 2 * 1'999'000U - 499'750U + 5) << "all frames of two events at once";
}

TEST(PlanTest, WithoutAPeriodTheBandwidthCounts) {
  AttributeSet said;
  said.set(Attribute::bandwidth, 1'000'000).set(Attribute::max_payload, 64);
  const Policing p = policing_of(said, 1);
  EXPECT_EQ(p.per_frame, 0U);
  EXPECT_EQ(p.per_byte, 255'872U) << "1000 ns a byte, in 1/256, 500 ppm less";
  EXPECT_EQ(p.tolerance, 2 * 64 * Value{255'872} / 256);
  AttributeSet unsized;
  unsized.set(Attribute::bandwidth, 1'000'000);
  EXPECT_EQ(policing_of(unsized, 1, 1000).tolerance, p.per_byte * 2000 / 256)
      << "who states no size may send the largest there is";
  EXPECT_FALSE(policing_of({}, 1).any()) << "who says nothing was promised nothing";
  AttributeSet nothing;
  nothing.set(Attribute::bandwidth, 0);
  EXPECT_FALSE(policing_of(nothing, 1).any()) << "no rate follows from 0 bytes/s";
}

TEST(PlanTest, AGrantThatCrossesKnowsBothEnds) {
  System system = robot(0);
  const std::uint32_t other = kEtag + 1;
  system.networks[kRobotCan].bindings[0].id = other;
  const auto crossing = State(system).transits(kBridge, 0);
  ASSERT_EQ(crossing.size(), 1U);
  EXPECT_EQ(crossing[0].in.port, kSecondCan);
  EXPECT_EQ(crossing[0].in.id, kExtendedFlag | kId);
  EXPECT_EQ(crossing[0].out.port, kRobotCan);
  EXPECT_EQ(crossing[0].out.id, kExtendedFlag | (kId - kEtag + other));
  EXPECT_EQ(crossing[0].out.source_port, kSecondCan);
  EXPECT_EQ(crossing[0].out.entered_as, (FrameIdentity{crossing[0].in.id, crossing[0].in.mask}));
}

TEST(PlanTest, NothingCrossesThatIsRefusedOrStaysOrComesFromAProgramHere) {
  EXPECT_TRUE(State(robot(5)).transits(kBridge, 0).empty());
  System stays = robot(0);
  stays.publishers[0].place = network(kRobotCan);
  EXPECT_TRUE(State(stays).transits(kBridge, 0).empty());
  System here = robot(0);
  here.publishers[0].place = {Place::Kind::gateway, kBridge};
  here.publishers[0].uid = 1000;
  ASSERT_TRUE(only_verdict(State(here)).granted);
  EXPECT_TRUE(State(here).transits(kBridge, 0).empty());
}

TEST(PlanTest, PublishersThatCannotBeDistinguishedCrossOnce) {
  System system = robot(0);
  for (Network& n : system.networks) n.profile = Profile::raw;
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second switch";
  EXPECT_EQ(State(system).transits(kBridge, 0).size(), 1U);
}

TEST(PlanTest, NothingCrossesAsFramesOfCanThatComesFromEthernetOrGoesThere) {
  for (const auto& others : {std::vector{kSecondCan}, {kRobotCan}, {kSecondCan, kRobotCan}}) {
    System system = robot(0);
    for (const std::size_t n : others) {
      system.networks[n].kind = NetworkKind::udp_multicast;
      system.networks[n].bindings.clear();
    }
    system.publishers[0].node = 5;
    for (Port& port : system.gateways[kBridge].ports) port.sender = 1000;
    const State state(system);
    ASSERT_TRUE(only_verdict(state).granted);
    EXPECT_TRUE(state.transits(kBridge, 0).empty());
  }
}

TEST(PlanTest, RemoteFramesPassWhereTheBindingHasThemAndItsMaskSaysTheRest) {
  System system = robot(0);
  for (Network& n : system.networks) {
    n.profile = Profile::raw;
    n.bindings[0].id = 0x120;
    n.bindings[0].mask = 0x7f0;
    n.bindings[0].extended = false;
  }
  for (const bool remote : {false, true}) {
    for (Network& n : system.networks) n.bindings[0].remote_frames = remote;
    const GateState gates = State(system).gate_state(kBridge);
    ASSERT_EQ(gates.size(), 2U);
    for (const GateRule& rule : gates) {
      EXPECT_EQ(rule.entry.id, 0x120U);
      EXPECT_EQ(rule.entry.mask, kExtendedFlag | (remote ? 0 : kRemoteFlag) | (kAllBits & ~0xfU));
    }
  }
}

/// 8 bytes every 20 ms are 400 bytes/s, beside 1000 bytes/s; both clocks may be 500 ppm fast.
TEST(PlanTest, OneThatStatesAPeriodAndOneThatStatesARateSendSoManyBytesTogether) {
  System system = robot(0);
  for (Network& n : system.networks) n.profile = Profile::raw;
  system.subscribers[0].attributes = AttributeSet{}.set(Attribute::max_payload, 8);
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second switch";
  AttributeSet periodic;
  periodic.set(Attribute::period, 20 * kMs).set(Attribute::max_payload, 8);
  AttributeSet stream;
  stream.set(Attribute::bandwidth, 1000).set(Attribute::max_payload, 8);
  std::vector<Policing> found;
  for (const bool turned : {false, true}) {
    system.publishers[turned ? 1 : 0].attributes = periodic;
    system.publishers[turned ? 0 : 1].attributes = stream;
    const GateState gates = State(system).gate_state(kBridge);
    const GateRule* in = find(gates, kSecondCan, Direction::ingress);
    ASSERT_NE(in, nullptr);
    EXPECT_TRUE(in->pass);
    found.push_back(in->policing);
  }
  EXPECT_EQ(found[0], found[1]) << "whoever is described first";
  EXPECT_EQ(found[0].per_frame, 0U);
  EXPECT_NEAR(static_cast<double>(found[0].per_byte), 256 * 1e9 / (1400 * 1.0005), 100);
}

TEST(PlanTest, WhoCannotBeToldFromOneThatStatesNoRateHasNoLimit) {
  System system = robot(0);
  for (Network& n : system.networks) n.profile = Profile::raw;
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second switch";
  for (const std::size_t silent : {0, 1}) {
    System one = system;
    one.publishers[silent].attributes.clear(Attribute::period);
    const GateState gates = State(one).gate_state(kBridge);
    const GateRule* in = find(gates, kSecondCan, Direction::ingress);
    ASSERT_NE(in, nullptr);
    EXPECT_FALSE(in->policing.any()) << silent;
  }
}

TEST(PlanTest, EntriesOfSeveralPublishersAreKnown) {
  System system = robot(0);
  const auto shared = [&] {
    const State state(system);
    return shared_rules(state.system(), state.members(), 0, state.decisions()[0].verdicts, kBridge);
  };
  EXPECT_TRUE(shared().empty()) << "there is one";
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second switch";
  system.publishers[1].node = 9;
  EXPECT_TRUE(shared().empty()) << "each has its node";
  // Where frames do not say their node as they leave, their mark still does.
  system.networks[kRobotCan].profile = Profile::raw;
  EXPECT_TRUE(shared().empty());
  system.networks[kSecondCan].profile = Profile::raw;
  const auto both = shared();
  ASSERT_EQ(both.size(), 2U);
  for (const SharedRule& one : both) EXPECT_EQ(one.publishers, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(entries_of(both)[0], both[0].rule.entry);
}

TEST(PlanTest, OnlyWhereFramesComeInTheyArePoliced) {
  const GateState rules = State(robot(0)).gate_state(kBridge);
  ASSERT_EQ(rules.size(), 2U);
  for (const GateRule& rule : rules) {
    EXPECT_EQ(rule.policing.any(), rule.entry.direction == Direction::ingress);
    EXPECT_FALSE(rule.policing.counts_only);
  }
  System lenient = robot(0);
  for (Port& port : lenient.gateways[kBridge].ports) port.excess = Excess::pass;
  for (const GateRule& rule : State(lenient).gate_state(kBridge))
    EXPECT_EQ(rule.policing.counts_only, rule.entry.direction == Direction::ingress);
}

}  // namespace
}  // namespace mlcca::core::testing
