// SPDX-License-Identifier: BSD-2-Clause
// What is drafted from traffic of Ethernets, alone and with buses beside them.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>

#include "base/big_endian.hpp"
#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "description/read.hpp"
#include "relay/afp.hpp"
#include "relay/layers/datagram.hpp"
#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/draft.hpp"

namespace mlcca::learn {
namespace {

using test::described;
using test::event;
using test::kDistance;
using test::kMs;
using test::kSecond;
using test::refused_in;
using test::Sent;
using test::station;
using test::Traffic;

constexpr std::uint64_t kVelocity = 0x56656c6f63697479;

Draft draft_from(const std::vector<Sent>& sent, std::vector<std::string> names,
                 DraftOptions options = {}) {
  Observer observer;
  for (const Sent& one : sent) observer.add(one.frame());
  std::vector<Medium> media;
  for (const auto& name : names)
    media.push_back(name.starts_with("eth") ? Medium::ethernet : Medium::can);
  observer.finish(names.size(), media);
  return draft_of(observer, names, options);
}

std::vector<Sent> lan(std::uint64_t seed, std::uint64_t seconds) {
  Traffic traffic(seed);
  traffic.events(0, kDistance, station(7), 20 * kMs, kMs / 2, 8, seconds, 500)
      .events(0, kDistance, station(8), 50 * kMs, kMs, 8, seconds)
      .events(0, kVelocity, station(7), 100 * kMs, 3 * kMs, 300, seconds);
  return traffic.sent();
}

/// So many datagrams that are no events, from each of these stations.
std::vector<Sent> with_malformed(const std::vector<std::pair<std::uint8_t, unsigned>>& senders) {
  auto sent = lan(1, 10);
  for (const auto& [number, count] : senders)
    for (unsigned i = 0; i < count; ++i) {
      Sent& bad = sent.emplace_back(event(kSecond + i * kMs, 0, kDistance, station(number), {1}));
      bad.data[8] = 77;
    }
  return test::in_order(std::move(sent));
}

bool says(const Draft& draft, const std::string& text) {
  return std::ranges::any_of(draft.left_out,
                             [&](const std::string& line) { return line.contains(text); });
}

TEST(EthernetDraft, WhatIsNoEventHasAnInterfaceAndSenders) {
  EXPECT_TRUE(says(draft_from(with_malformed({{7, 3}, {9, 5}}), {"eth0"}),
                   "eth0: 8 datagrams to FAMOUSO's ports that are no events: 5 from 192.0.2.9, 3 "
                   "from 192.0.2.7"));
  EXPECT_TRUE(says(draft_from(with_malformed({{7, 1}}), {"eth0"}),
                   "eth0: 1 datagram to FAMOUSO's ports that is no event: 1 from 192.0.2.7"));
}

TEST(EthernetDraft, OfManySendersOfWhatIsNoEventThoseWithMostAreNamed) {
  std::vector<std::pair<std::uint8_t, unsigned>> senders;
  for (std::uint8_t i = 0; i < 200; ++i) senders.emplace_back(10 + i, i == 3 ? 50 : 2);
  const Draft draft = draft_from(with_malformed(senders), {"eth0"});
  EXPECT_TRUE(says(draft,
                   "448 datagrams to FAMOUSO's ports that are no events: 50 from 192.0.2.13, "
                   "2 from 192.0.2.10, "));
  EXPECT_TRUE(says(draft, ", 384 from others"));
}

TEST(EthernetDraft, HasTheSubjectsTheSendersAndTheirTimes) {
  const Draft draft = draft_from(lan(1, 60), {"eth0"});
  ASSERT_EQ(draft.channels.size(), 2U);
  const DraftChannel& distance = draft.channels[0];
  EXPECT_EQ(distance.name, "eth0-Distance") << "its subject is text";
  EXPECT_EQ(distance.identifier, "0x44697374616e6365");
  EXPECT_EQ(distance.period, 50 * kMs) << "all of its publishers can be subscribed";
  EXPECT_EQ(distance.bytes, 8U);
  ASSERT_EQ(distance.publishers.size(), 2U);
  EXPECT_EQ(distance.publishers[0].period, 20 * kMs);
  EXPECT_EQ(draft.channels[1].bytes, 300U);
  const auto system = described(draft);
  ASSERT_EQ(system.networks.size(), 1U);
  EXPECT_EQ(system.networks[0].kind, core::NetworkKind::udp_multicast);
  EXPECT_EQ(system.networks[0].profile, core::Profile::famouso);
  EXPECT_EQ(system.channels[0].subject, kDistance);
  ASSERT_EQ(system.publishers.size(), 3U);
  EXPECT_EQ(core::to_text(system.publishers[0].station), "192.0.2.7");
  EXPECT_EQ(core::to_text(system.publishers[1].station), "192.0.2.8");
  EXPECT_TRUE(draft.xml.contains("its subject is the text Distance")) << draft.xml;
  EXPECT_TRUE(draft.xml.contains("its frames are from 02:00:5e:00:00:07")) << draft.xml;
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(EthernetDraft, SubjectsThatAreNoTextOrLikeOthersHaveNamesOfTheirOwn) {
  constexpr std::uint64_t spaced = 0x6120620000000000;   // "a b"
  constexpr std::uint64_t scored = 0x615f620000000000;   // "a_b"
  constexpr std::uint64_t no_text = 0x6100620000000000;  // "a", a null character, "b"
  Traffic traffic(1);
  for (const std::uint64_t subject : {spaced, scored, no_text})
    traffic.events(0, subject, station(7), 20 * kMs, kMs / 2, 8, 30);
  const Draft draft = draft_from(traffic.sent(), {"eth0"});
  std::map<std::uint64_t, std::string> names;
  for (const auto& channel : draft.channels) names[channel.subject.value()] = channel.name;
  EXPECT_EQ(names,
            (std::map<std::uint64_t, std::string>{
                {no_text, "eth0-6100620000000000"}, {spaced, "eth0-a_b"}, {scored, "eth0-a_b-2"}}));
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(EthernetDraft, IsADescriptionOfWhichEverythingIsGranted) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    EXPECT_EQ(refused_in(draft_from(lan(seed, 30), {"eth0"})), 0U);
}

/// A gate that holds what the draft grants on an Ethernet.
class EtherGate {
 public:
  explicit EtherGate(const Draft& draft) : state_(described(draft)) {
    for (const core::GateRule& rule : state_.gate_state(0))
      if (rule.entry.direction == core::Direction::ingress && rule.pass && rule.entry.subject != 0)
        rules_.push_back({rule, 0});
  }
  bool passes(const Sent& sent) {
    const auto parsed = relay::parse_datagram(sent.data);
    Held* held = nullptr;
    for (Held& one : rules_)
      if (one.rule.entry.subject == parsed->subject &&
          (one.rule.entry.station.bits == sent.datagram->source ||
           (one.rule.entry.station.is_wildcard() && held == nullptr)))
        held = &one;
    if (held == nullptr || parsed->data.size() > held->rule.entry.max_length ||
        (parsed->is_fragment && !held->rule.entry.fragmented))
      return false;
    const auto& policing = held->rule.policing;
    if (policing.per_frame == 0) return true;
    if (sent.ns + policing.tolerance < held->due) return false;
    held->due = std::max(held->due, sent.ns) + policing.per_frame;
    return true;
  }

 private:
  struct Held {
    core::GateRule rule;
    std::uint64_t due;
  };
  core::State state_;
  std::vector<Held> rules_;
};

TEST(EthernetDraft, LearnedOnTheFirstHalfItDropsNothingOfTheSecond) {
  test::Share dropped;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto sent = lan(seed, 240);
    EtherGate gate(draft_from(test::before(sent, 120 * kSecond), {"eth0"}));
    dropped += test::from(sent, 120 * kSecond, gate, [](const Sent&) { return true; });
  }
  EXPECT_GT(dropped.of, 50'000U);
  EXPECT_LT(dropped.frames * 1000, dropped.of) << dropped.frames << " of " << dropped.of;
}

TEST(EthernetDraft, AttacksAreDropped) {
  EtherGate gate(draft_from(lan(7, 60), {"eth0"}));
  const auto passing = [&](std::uint64_t subject, std::uint8_t sender, std::size_t bytes,
                           std::uint64_t gap, unsigned count) {
    unsigned passed = 0;
    for (unsigned i = 0; i < count; ++i)
      if (gate.passes(event(100 * kSecond + i * gap, 0, subject, station(sender),
                            std::vector<std::uint8_t>(bytes))))
        ++passed;
    return passed;
  };
  EXPECT_EQ(passing(kDistance + 1, 7, 8, kMs, 100), 0U) << "an unknown subject";
  EXPECT_EQ(passing(kDistance, 9, 8, kMs, 100), 0U) << "another sender";
  EXPECT_EQ(passing(kDistance, 7, 9, 20 * kMs, 100), 0U) << "a longer event";
  EXPECT_LE(passing(kDistance, 7, 8, kMs / 5, 5000), 55U) << "a flood for a second";
}

TEST(EthernetDraft, WhatComesFromABusIsOneChannelWithTheSubject) {
  Traffic traffic(3);
  traffic.periodic(0, 0x100, 20 * kMs, kMs / 2, 8, 60)
      .periodic(0, 0x200, 50 * kMs, kMs / 2, 8, 60)
      .events(1, kVelocity, station(7), 100 * kMs, kMs, 8, 60)
      .to_ethernet(0, 0x100, 1, kDistance);
  const Draft draft = draft_from(traffic.sent(), {"can0", "eth0"});
  ASSERT_EQ(draft.channels.size(), 3U) << draft.xml;
  const DraftChannel& crossing = draft.channels[0];
  EXPECT_EQ(crossing.name, "can0-100");
  EXPECT_EQ(crossing.subject, kDistance);
  EXPECT_EQ(crossing.crosses_to, std::vector<std::string>{"eth0"});
  const auto system = described(draft);
  EXPECT_EQ(system.channels[0].subject, kDistance);
  ASSERT_EQ(system.networks[0].bindings.size(), 2U);
  EXPECT_EQ(system.networks[0].bindings[0].id, 0x100U);
  EXPECT_EQ(std::ranges::count(system.publishers, std::size_t{0}, &core::Publisher::channel), 1);
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
}

TEST(EthernetDraft, WhatGoesToABusIsOneChannelWithABindingThere) {
  Traffic traffic(4);
  traffic.events(1, kDistance, station(7), 20 * kMs, kMs / 2, 8, 60)
      .events(1, kDistance, station(8), 50 * kMs, kMs / 2, 8, 60)
      .to_bus(1, kDistance, station(7), 0, 0x123)
      .to_bus(1, kDistance, station(8), 0, 0x123);
  const Draft draft = draft_from(traffic.sent(), {"can0", "eth0"});
  ASSERT_EQ(draft.channels.size(), 1U) << draft.xml;
  EXPECT_EQ(draft.channels[0].crosses_to, std::vector<std::string>{"can0"});
  EXPECT_EQ(draft.channels[0].publishers.size(), 2U);
  EXPECT_TRUE(draft.channels[0].binding_xml.contains("can0"));
  described(draft);
}

TEST(EthernetDraft, WhatIsFilledUpForAFrameOfCanFdIsTheSameEvent) {
  Traffic traffic(4);
  traffic.events(1, kDistance, station(7), 20 * kMs, kMs / 2, 9, 60)
      .to_bus(1, kDistance, station(7), 0, 0x123);
  auto sent = traffic.sent();
  for (Sent& one : sent) {
    if (one.datagram) continue;
    one.fd = true;
    one.data.resize(12);
  }
  const Draft draft = draft_from(sent, {"can0", "eth0"});
  ASSERT_EQ(draft.channels.size(), 1U) << draft.xml;
  EXPECT_EQ(draft.channels[0].bytes, 9U);
  EXPECT_TRUE(draft.channels[0].binding_xml.at("can0").contains("format=\"fd\""));
  described(draft);
}

TEST(EthernetDraft, WhatHasSeveralFramesOnABusIsTheSameEvent) {
  constexpr std::uint32_t id = kExtended | 0x7dU << 22U | 0x21U << 14U | 0x100U;
  Observer observer;
  observer.state(0, core::Profile::famouso);
  for (std::uint64_t i = 0; i < 100; ++i) {
    std::vector<std::uint8_t> data(100, static_cast<std::uint8_t>(i));
    std::uint64_t ns = kSecond + i * 50 * kMs;
    auto fragments = relay::afp::Fragments::of(relay::afp::kCan, data);
    while (const auto fragment = fragments->next())
      observer.add(Sent{ns += kMs / 4, 0, id | 1U << 21U, *fragment}.frame());
    observer.add(event(ns + kMs, 1, kDistance, station(1), data).frame());
  }
  observer.finish(2);
  const Draft draft = draft_of(observer, {"can0", "eth0"}, {});
  ASSERT_EQ(draft.channels.size(), 1U) << draft.xml;
  EXPECT_EQ(draft.channels[0].bytes, 100U);
  EXPECT_EQ(draft.channels[0].crosses_to, std::vector<std::string>{"eth0"});
}

TEST(EthernetDraft, OnABusWithNodesTheSenderHasTheOneThatItsFramesHadThere) {
  constexpr std::uint32_t id = kExtended | 0x7dU << 22U | 0x21U << 14U | 0x100U;
  Traffic traffic(4);
  traffic.events(1, kDistance, station(7), 20 * kMs, kMs / 2, 8, 60)
      .to_bus(1, kDistance, station(7), 0, id);
  auto sent = traffic.sent();
  Observer observer;
  observer.state(0, core::Profile::famouso);
  for (const Sent& one : sent) observer.add(one.frame());
  observer.finish(2);
  const Draft draft = draft_of(observer, {"can0", "eth0"}, {});
  ASSERT_EQ(draft.channels.size(), 1U) << draft.xml;
  const auto system = described(draft);
  ASSERT_EQ(system.publishers.size(), 1U);
  EXPECT_EQ(system.publishers[0].node, 0x21);
  EXPECT_EQ(system.publishers[0].priority, 0x7d);
  EXPECT_EQ(core::to_text(system.publishers[0].station), "192.0.2.7");
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
}

TEST(EthernetDraft, ThatItCrossesIsSeenInRecordingsThatAreReadOneAfterTheOther) {
  Traffic traffic(5);
  traffic.periodic(0, 0x100, 20 * kMs, kMs / 2, 8, 30).to_ethernet(0, 0x100, 1, kDistance);
  auto sent = traffic.sent();
  std::ranges::stable_sort(sent, std::ranges::greater{}, &Sent::interface);
  const Draft draft = draft_from(sent, {"can0", "eth0"});
  ASSERT_EQ(draft.channels.size(), 1U);
  EXPECT_EQ(draft.channels[0].name, "can0-100");
}

TEST(EthernetDraft, WhatIsAlikeByChanceIsLeftToAPerson) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 200; ++i) {
    sent.push_back({kSecond + i * 50 * kMs, 0, 0x100, {1}});
    sent.push_back(event(kSecond + i * 50 * kMs + kMs, 1, kDistance, station(7), {1}));
  }
  const Draft draft = draft_from(sent, {"can0", "eth0"});
  EXPECT_EQ(draft.channels.size(), 2U);
  ASSERT_EQ(draft.left_out.size(), 1U);
  EXPECT_EQ(draft.left_out[0],
            "eth0 0x44697374616e6365 had the same few contents as can0 0x100 shortly before: if it "
            "is one channel, describe it as one");
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(EthernetDraft, ASubjectOnTwoEthernetsIsOneChannel) {
  Traffic traffic(6);
  traffic.events(0, kDistance, station(7), 20 * kMs, kMs, 8, 10)
      .events(1, kDistance, station(9), 20 * kMs, kMs, 8, 10);
  const Draft draft = draft_from(traffic.sent(), {"eth0", "eth1"});
  ASSERT_EQ(draft.channels.size(), 1U);
  EXPECT_EQ(draft.channels[0].publishers.size(), 2U);
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(EthernetDraft, ProgramsOfTheHostAreOnePublisherOfTheGateway) {
  Traffic traffic(7);
  traffic.events(0, kDistance, station(1), 20 * kMs, kMs, 8, 10)
      .events(0, kDistance, station(2), 20 * kMs, kMs, 8, 10);
  auto sent = traffic.sent();
  for (Sent& one : sent) one.local = true;
  const Draft draft = draft_from(sent, {"eth0"});
  const auto system = described(draft);
  ASSERT_EQ(system.publishers.size(), 1U);
  EXPECT_EQ(system.publishers[0].place.kind, core::Place::Kind::gateway);
  ASSERT_EQ(system.subscribers.size(), 1U);
  EXPECT_EQ(system.subscribers[0].place.kind, core::Place::Kind::network);
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(EthernetDraft, MoreSendersThanAGateDistinguishesShareAnEntry) {
  Traffic traffic(8);
  for (std::uint8_t i = 1; i <= 20; ++i)
    traffic.events(0, kDistance, station(i), (10U + i) * kMs, kMs, 8, 10);
  const Draft draft = draft_from(traffic.sent(), {"eth0"});
  const auto system = described(draft);
  EXPECT_EQ(system.publishers.size(), 20U);
  EXPECT_EQ(std::ranges::count_if(system.publishers,
                                  [](const auto& p) { return !p.station.is_wildcard(); }),
            7);
  EXPECT_EQ(refused_in(draft), 0U);
  EXPECT_TRUE(draft.left_out.at(0).contains("20 senders")) << draft.left_out[0];
}

TEST(EthernetDraft, OtherTrafficIsNamedAndNotDrafted) {
  std::vector<Sent> sent;
  for (int i = 0; i < 100; ++i) {
    sent.push_back(event(kSecond, 0, kDistance, station(7), {1}));
    sent.back().datagram->port = sent.back().datagram->source_port = 5353;
  }
  const Draft draft = draft_from(sent, {"eth0"});
  EXPECT_TRUE(draft.channels.empty());
  EXPECT_EQ(described(draft).networks.at(0).profile, core::Profile::none);
  ASSERT_EQ(draft.left_out.size(), 3U);
  EXPECT_TRUE(
      says(draft, "eth0: 100 datagrams of other traffic, which needs no channel: port 5353 (100)"));
  EXPECT_TRUE(says(draft, "eth0: no event was seen there: its Kind udp-multicast is assumed"));
}

TEST(EthernetDraft, AnEthernetWithoutAProfileIsSaid) {
  auto sent = lan(1, 30);
  sent.push_back(event(2 * kSecond, 1, kDistance, station(7), {1}));
  sent.back().datagram->port = sent.back().datagram->source_port = 5353;
  const Draft draft = draft_from(test::in_order(std::move(sent)), {"eth0", "eth1"});
  const auto system = described(draft);
  EXPECT_EQ(system.networks.at(0).profile, core::Profile::famouso);
  EXPECT_EQ(system.networks.at(1).profile, core::Profile::none);
  EXPECT_TRUE(says(draft,
                   "eth1: its network is drafted without a Profile, so it has no gate: no datagram "
                   "went to FAMOUSO's ports, 9999 and 8888. If it has FAMOUSO's events, state "
                   "--profile eth1=famouso"));
  EXPECT_FALSE(says(draft, "eth0: its network"));
  EXPECT_TRUE(draft.xml.contains("<!-- Without a Profile it has no gate. -->")) << draft.xml;
}

/// The events of these subjects go to port 8888, where FAMOUSO broadcasts.
std::vector<Sent> broadcast(std::vector<Sent> sent, const std::set<std::uint64_t>& subjects) {
  for (Sent& one : sent) {
    if (!subjects.contains(from_big_endian(std::span(one.data).first(8)))) continue;
    one.datagram->port = relay::kBroadcastPort;
    one.datagram->destination = 0xffffffff;
  }
  return sent;
}

TEST(EthernetDraft, WhatIsBroadcastIsDraftedAsBroadcast) {
  const Draft draft = draft_from(broadcast(lan(1, 10), {kDistance, kVelocity}), {"eth0"});
  EXPECT_EQ(described(draft).networks.at(0).kind, core::NetworkKind::udp_broadcast);
  EXPECT_EQ(draft.channels.size(), 2U);
  EXPECT_FALSE(draft.xml.contains("Kind is assumed")) << draft.xml;
  EXPECT_FALSE(says(draft, "is assumed"));
  EXPECT_FALSE(draft_from(lan(1, 10), {"eth0"}).xml.contains("Kind is assumed"));
}

TEST(EthernetDraft, OfTwoTransportsItDraftsTheOneOfMostEventsAndSaysSo) {
  // 702 events of Distance, 100 of Velocity.
  const Draft most = draft_from(broadcast(lan(1, 10), {kDistance}), {"eth0"});
  EXPECT_EQ(described(most).networks.at(0).kind, core::NetworkKind::udp_broadcast);
  EXPECT_TRUE(most.xml.contains("<!-- Its Kind is assumed: 100 of ")) << most.xml;
  EXPECT_TRUE(says(most,
                   "datagrams with events are of udp-multicast (port 9999), the others of "
                   "udp-broadcast (port 8888): udp-broadcast is assumed, by which nobody receives "
                   "all of 0x56656c6f63697479"));
  const Draft few = draft_from(broadcast(lan(1, 10), {kVelocity}), {"eth0"});
  EXPECT_EQ(described(few).networks.at(0).kind, core::NetworkKind::udp_multicast);
  EXPECT_TRUE(few.xml.contains("of udp-broadcast (port 8888). -->")) << few.xml;
  EXPECT_TRUE(says(few,
                   "udp-multicast is assumed, by which nobody receives all of "
                   "0x56656c6f63697479"));
}

TEST(EthernetDraft, WithoutEventsTheKindIsAssumed) {
  Observer observer;
  observer.state(0, core::Profile::famouso);
  const std::vector media{Medium::ethernet};
  observer.finish(1, media);
  const Draft draft = draft_of(observer, {"eth0"}, {});
  const auto system = described(draft);
  EXPECT_EQ(system.networks.at(0).kind, core::NetworkKind::udp_multicast);
  EXPECT_EQ(system.networks.at(0).profile, core::Profile::famouso);
  EXPECT_TRUE(draft.xml.contains("<!-- Its Kind is assumed: no event was seen. -->")) << draft.xml;
  EXPECT_TRUE(says(draft, "eth0: no event was seen there: its Kind udp-multicast is assumed"));
}

TEST(EthernetDraft, WhatTwoGatewaysCarryInACircleIsStillDrafted) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 100; ++i)
    for (std::uint32_t hop = 0; hop < 3; ++hop) {
      const std::uint64_t ns = kSecond + i * 90 * kMs + hop * 30 * kMs;
      if (hop == 2)
        sent.push_back(event(ns, 2, kDistance, station(7), {1}));
      else
        sent.push_back({ns, hop, 0x100 + hop, {1}});
      sent.back().local = true;
    }
  const Draft draft = draft_from(sent, {"can0", "can1", "eth0"});
  EXPECT_GE(draft.channels.size(), 1U);
  described(draft);
}

TEST(EthernetDraft, LongNamesStayNames) {
  Traffic traffic(9);
  traffic.events(0, kDistance, station(250), 20 * kMs, kMs, 8, 10);
  const Draft draft = draft_from(traffic.sent(), {"eth" + std::string(60, 'x')});
  EXPECT_EQ(described(draft).publishers.size(), 1U);
}

}  // namespace
}  // namespace mlcca::learn
