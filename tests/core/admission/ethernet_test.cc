// SPDX-License-Identifier: BSD-2-Clause
// Networks whose frames carry the subject itself: no binding, and a gate of another kind.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/design/inspect.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/gates/plan.hpp"
#include "core/model/medium.hpp"
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

/// The switch on the second bus or network, which is Ethernet. What the kernel can carry it does.
System from_ethernet() {
  System system = robot(0);
  system.gateways[kBridge].forwarder = Forwarder::can_gw;
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
    EXPECT_FALSE(rule.entry.fragmented);
    EXPECT_FALSE(rule.entry.classic);
  }
}

TEST(EthernetTest, NoProgramCarriesEventsFromOneKindToTheOtherUnlessItIsStated) {
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
  for (const GateRule& rule : gates_of(8183)) EXPECT_FALSE(rule.entry.fragmented);
  for (const GateRule& rule : gates_of(8184)) {
    EXPECT_TRUE(rule.entry.fragmented);
    EXPECT_EQ(rule.entry.max_length, 8183U);
  }
}

/// Two publishers of one channel on the same network; its name, its period in ns, its address.
System two_on_ethernet(const char* first, const char* second) {
  System system = from_ethernet();
  system.networks[kRobotCan] = ethernet("mesh");
  system.publishers.push_back(system.publishers[0]);
  system.publishers[1].name = "second";
  system.publishers[0].station = station_of(first).value_or(Station{});
  system.publishers[1].station = station_of(second).value_or(Station{});
  return system;
}

TEST(EthernetTest, PublishersWithAddressesHaveEntriesAndLimitsOfTheirOwn) {
  const System system = two_on_ethernet("192.0.2.1", "192.0.2.2");
  const GateState gates = State(system).gate_state(kBridge);
  ASSERT_EQ(gates.size(), 4U) << "each comes in and, carried by the kernel, leaves as it came";
  for (const GateRule& rule : gates) {
    const bool first = rule.entry.station == station_of("192.0.2.1");
    EXPECT_TRUE(first || rule.entry.station == station_of("192.0.2.2"));
    if (rule.entry.direction == Direction::ingress) {
      EXPECT_EQ(rule.policing, policing_of(system.publishers[first ? 0 : 1].attributes, 1));
    }
  }
}

TEST(EthernetTest, PublishersWithoutAddressesShareOneLimit) {
  for (const char* address : {"", "192.0.2.1"}) {
    const System system = two_on_ethernet(address, address);
    const GateState gates = State(system).gate_state(kBridge);
    ASSERT_EQ(gates.size(), 2U);
    const auto in = std::ranges::find(gates, Direction::ingress,
                                      [](const GateRule& r) { return r.entry.direction; });
    const Value alone = policing_of(system.publishers[0].attributes, 1).per_frame;
    EXPECT_EQ(in->policing.per_frame, alone / 2);
  }
}

TEST(EthernetTest, PublishersThatShareALimitShareTheLongestEvent) {
  System system = two_on_ethernet("", "");
  system.publishers[0].attributes.set(Attribute::max_payload, 8);
  system.publishers[1].attributes.set(Attribute::max_payload, 100);
  const State state(system);
  const GateState gates = state.gate_state(kBridge);
  ASSERT_EQ(gates.size(), 2U);
  for (const GateRule& rule : gates) EXPECT_EQ(rule.entry.max_length, 100U);
  for (const Verdict& v : state.decisions()[0].verdicts)
    for (const GateRule& rule : gate_state(state.system(), state.members(), v, kBridge))
      EXPECT_NE(std::ranges::find(gates, rule.entry, &GateRule::entry), gates.end())
          << "each is counted where all are";
  system.publishers[0].station = *station_of("192.0.2.1");
  const GateState apart = State(system).gate_state(kBridge);
  ASSERT_EQ(apart.size(), 4U);
  for (const GateRule& rule : apart)
    EXPECT_EQ(rule.entry.max_length, rule.entry.station.is_wildcard() ? 100U : 8U);
}

TEST(EthernetTest, APublisherElsewhereMakesNoEventLonger) {
  System system = two_on_ethernet("", "");
  system.publishers[0].attributes.set(Attribute::max_payload, 8);
  system.publishers[1].attributes.set(Attribute::max_payload, 100);
  system.publishers[1].place = network(kRobotCan);
  for (const GateRule& rule : State(system).gate_state(kBridge)) {
    const bool enters = rule.entry.direction == Direction::ingress && rule.entry.port == kSecondCan;
    EXPECT_EQ(rule.entry.max_length, enters ? 8U : rule.entry.max_length);
  }
}

TEST(EthernetTest, BehindABusTheyAreOne) {
  System system = two_on_ethernet("192.0.2.1", "192.0.2.2");
  system.networks[kRobotCan] = robot(0).networks[kRobotCan];
  for (Network& n : system.networks)
    if (n.kind == NetworkKind::can) n.profile = Profile::raw;
  system.publishers[0].attributes.set(Attribute::max_payload, 4);
  system.publishers[1].attributes.set(Attribute::max_payload, 8);
  system.gateways[kBridge].ports[kRobotCan].sender = 1000;
  std::vector<std::uint16_t> lengths;
  for (const GateRule& rule : State(system).gate_state(kBridge))
    if (rule.entry.port == kRobotCan) lengths.push_back(rule.entry.max_length);
  EXPECT_EQ(lengths, std::vector<std::uint16_t>{8});
}

/// Frames of so many bytes that pass at once, and in a time; ns.
std::uint64_t passed(const Policing& p, Value bytes, Value time) {
  const Value cost = p.per_frame + (bytes * p.per_byte >> 8U);
  return (p.tolerance + time) / cost + 1;
}

TEST(EthernetTest, PublishersThatShareALimitHaveTheSumOfTheirRates) {
  constexpr Value second = 1'000'000'000;
  System system = two_on_ethernet("", "");
  const auto in = [&system] {
    const GateState gates = State(system).gate_state(kBridge);
    return std::ranges::find(gates, Direction::ingress,
                             [](const GateRule& r) { return r.entry.direction; })
        ->policing;
  };
  system.publishers[0].attributes.set(Attribute::period, 50'000'000);
  system.publishers[1].attributes.set(Attribute::period, 10'000'000);
  EXPECT_EQ(passed(in(), 8, 0), 4U) << "one of each, and one of each that is early";
  EXPECT_EQ(passed(in(), 8, 10 * second), 10 * 120 + 4U);

  // One by its Bandwidth: both by bytes.
  system.publishers[1].attributes.clear(Attribute::period);
  system.publishers[1].attributes.set(Attribute::bandwidth, 800).set(Attribute::max_payload, 8);
  system.publishers[0].attributes.set(Attribute::max_payload, 8);
  ASSERT_TRUE(in().any());
  EXPECT_EQ(in().per_frame, 0U);
  const auto one_second = passed(in(), 8, second) - passed(in(), 8, 0);
  EXPECT_GE(one_second, 120U);
  EXPECT_LE(one_second, 121U);
}

TEST(EthernetTest, AGateDistinguishesEightPublishersOfASubject) {
  System system = two_on_ethernet("192.0.2.1", "192.0.2.2");
  const auto add = [&system] {
    Publisher p = system.publishers[0];
    p.name = "publisher-" + std::to_string(system.publishers.size());
    p.station = Station{system.publishers.back().station.bits + 1};
    system.publishers.push_back(p);
  };
  while (system.publishers.size() < kMostEntries) add();
  EXPECT_EQ(State(system).exceeds_capacity(kBridge), std::nullopt);
  EXPECT_EQ(inspect(system).channels[0].outcome, Outcome::fit);

  // One more at run time, and in the description.
  State state(system);
  Publisher newcomer = system.publishers[0];
  newcomer.station = *station_of("192.0.2.99");
  {
    const Proposal proposal = state.propose({7, 0, newcomer, {}});
    EXPECT_TRUE(
        proposal.exceeds_capacity(kBridge).value_or("").starts_with("more than 8 publishers"));
  }
  add();
  const std::string lack = State(system).exceeds_capacity(kBridge).value_or("");
  EXPECT_EQ(
      lack,
      "channel emergency-switch: more than 8 publishers of it leave gateway bridge by network "
      "mesh: a gate distinguishes no more of one subject");
  const Inspection found = inspect(system);
  EXPECT_EQ(found.channels[0].outcome, Outcome::unfit);
  EXPECT_NE(std::ranges::find(found.findings, FindingId::too_many, &Finding::id),
            found.findings.end());
  // Those that cannot be distinguished are one to a gate.
  for (Publisher& p : system.publishers) p.station = {};
  EXPECT_EQ(State(system).exceeds_capacity(kBridge), std::nullopt);
}

TEST(EthernetTest, BehindABusTheFirstAddressIsUnknown) {
  // lan - bridge - bus - second bridge - far: the second bridge's program sends it again.
  System system = from_ethernet();
  system.publishers[0].station = *station_of("192.0.2.1");
  system.gateways[kBridge].ports[kRobotCan].sender = 1000;
  system.networks.push_back(ethernet("far"));
  system.subscribers[0].place = network(2);
  Gateway second = system.gateways[kBridge];
  second.name = "second";
  second.ports.resize(2);
  second.ports[0].network = kRobotCan;
  second.ports[1].network = 2;
  second.ports[1].sender = 1000;
  system.gateways.push_back(second);
  Gateway third = second;
  third.name = "third";
  third.ports[0].network = 2;
  system.networks.push_back(ethernet("farther"));
  third.ports[1].network = 3;
  system.gateways.push_back(third);
  system.subscribers[0].place = network(3);
  const State state(system);
  ASSERT_TRUE(state.decisions()[0].verdicts[0].granted);
  for (const GateRule& rule : state.gate_state(kBridge))
    EXPECT_EQ(rule.entry.station.is_wildcard(), rule.entry.direction == Direction::egress);
  for (const std::size_t gateway : {1U, 2U}) {
    const GateState gates = state.gate_state(gateway);
    EXPECT_EQ(gates.size(), 2U);
    for (const GateRule& rule : gates) EXPECT_TRUE(rule.entry.station.is_wildcard());
  }
}

TEST(EthernetTest, AnAddressIsThatOfOneStation) {
  for (const char* good :
       {"192.0.2.7", "1.0.0.0", "223.255.255.255", "10.0.0.255", "126.255.255.255", "128.0.0.0"})
    EXPECT_EQ(to_text(station_of(good).value()), good);
  EXPECT_EQ(to_text(station_of("02:AB:00:00:00:01").value()), "02:ab:00:00:00:01");
  EXPECT_EQ(station_of("0.0.0.1"), std::nullopt);
  for (const char* bad : {"", "192.0.2", "192.0.2.256", "192.0.2.7 ", " 192.0.2.7", "192.0.2.07",
                          "192.0.2.7.1", "224.0.0.1", "255.255.255.255", "0.0.0.0", "fe80::1",
                          "02:00:00:00:00", "2:0:0:0:0:1", "03:00:00:00:00:01", "00:00:00:00:00:00",
                          "02:00:00:00:00:0g", "02-00-00-00-00-01", "+1.2.3.4"})
    EXPECT_FALSE(station_of(bad)) << bad;
  for (const char* loopback : {"127.0.0.0", "127.0.0.1", "127.255.255.255"})
    EXPECT_FALSE(station_of(loopback)) << loopback;
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

TEST(EthernetTest, HasSubscriptionsOnlyAsControlTraffic) {
  System system = from_ethernet();
  system.gateways[kBridge].ports[kSecondCan].control_uid = 4711;
  std::vector<GateRule> rules = control_rules(system, kBridge);
  EXPECT_NE(std::erase_if(rules, [](const auto& r) { return r.entry.port == kRobotCan; }), 0U);
  ASSERT_EQ(rules.size(), 2U);
  for (const GateRule& rule : rules) {
    EXPECT_EQ(rule.entry.subject, 0x5355425343524942U);
    EXPECT_EQ(rule.entry.id, 0U) << "frames name the subject itself";
    EXPECT_EQ(rule.entry.mask, 0U);
    EXPECT_FALSE(rule.entry.classic);
    EXPECT_EQ(rule.entry.max_length, 8U);
    EXPECT_FALSE(rule.entry.source_port) << "it never crosses a gateway";
    EXPECT_TRUE(rule.entry.station.is_wildcard());
    EXPECT_TRUE(rule.pass);
    EXPECT_TRUE(rule.policing.any());
  }
  EXPECT_EQ(rules[1].entry.direction, Direction::egress);
  EXPECT_EQ(rules[1].entry.uid, 4711U);
  system.channels.emplace_back().subject = 0x5355425343524942;
  for (const GateRule& rule : control_rules(system, kBridge))
    EXPECT_EQ(rule.entry.port, kRobotCan) << "the subject is a channel's";
}

TEST(EthernetTest, WithoutAProfileNothingIsGated) {
  System system = from_ethernet();
  system.networks[kSecondCan].profile = Profile::none;
  for (const GateRule& rule : State(system).gate_state(kBridge))
    EXPECT_EQ(rule.entry.port, kRobotCan);
}

}  // namespace
}  // namespace mlcca::core::testing
