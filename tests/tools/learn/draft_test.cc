// SPDX-License-Identifier: BSD-2-Clause
// What is drafted from traffic: it is a description, it grants what was seen, and refuses what was
// not.
#include "tools/learn/draft.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "description/read.hpp"
#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using test::before;
using test::described;
using test::drafted;
using test::Gate;
using test::kMs;
using test::kNames;
using test::kSecond;
using test::refused_in;
using test::Sent;
using test::Traffic;

const DraftChannel& channel(const Draft& draft, std::string_view name) {
  static const DraftChannel none;
  const auto found = std::ranges::find(draft.channels, name, &DraftChannel::name);
  EXPECT_NE(found, draft.channels.end()) << name;
  return found == draft.channels.end() ? none : *found;
}

std::vector<Sent> two_buses(std::uint64_t seed, std::uint64_t seconds) {
  Traffic traffic(seed);
  traffic.periodic(0, 0x100, 10 * kMs, kMs / 3, 8, seconds, 1000)
      .periodic(0, 0x1a0, 20 * kMs, kMs, 6, seconds)
      .periodic(0, 0x2f0, 100 * kMs, 2 * kMs, 4, seconds)
      .periodic(0, 0x18fef100 | kExtended, 100 * kMs, 3 * kMs, 8, seconds)
      .bursts(1, 0x3e8, 4, kMs / 2, kSecond, seconds)
      .forwarded(0, 0x100, 1)
      .forwarded(0, 0x2f0, 1);
  return traffic.sent();
}

TEST(Draft, HasThePeriodsLengthsAndCrossingsThatWereSeen) {
  const Draft draft = drafted(two_buses(1, 60));
  ASSERT_EQ(draft.channels.size(), 5U);
  const auto& fast = channel(draft, "can0-100");
  EXPECT_TRUE(fast.periodic);
  EXPECT_EQ(fast.period, 10 * kMs);
  EXPECT_EQ(fast.bytes, 8U);
  EXPECT_EQ(fast.crosses_to, std::vector<std::string>{"can1"});
  EXPECT_EQ(fast.omission, 2U) << "one was lost, and one more is the margin";
  EXPECT_EQ(channel(draft, "can0-18FEF100").period, 100 * kMs);
  EXPECT_TRUE(channel(draft, "can0-1A0").crosses_to.empty());
  const auto& burst = channel(draft, "can1-3E8");
  EXPECT_FALSE(burst.periodic);
  EXPECT_GT(burst.period, 50 * kMs) << "a burst is no rate";
}

TEST(Draft, IsADescriptionOfWhichEverythingIsGranted) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    EXPECT_EQ(refused_in(drafted(two_buses(seed, 30))), 0U);
}

/// More frames than a queue holds by default wait there where so many channels cross.
TEST(Draft, QueuesHoldWhatCrosses) {
  for (const std::uint32_t channels : {10U, 11U, 12U, 40U}) {
    Traffic traffic(channels);
    for (std::uint32_t n = 0; n < channels; ++n)
      traffic.periodic(0, 0x100 + n, (20 + n % 4 * 10) * kMs, kMs / 3, 8, 20)
          .forwarded(0, 0x100 + n, 1);
    const Draft draft = drafted(traffic.sent());
    EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
    EXPECT_EQ(
        draft.xml.contains("<!-- So many frames may wait there: ip link set can1 txqueuelen "),
        channels > 10)
        << draft.xml;
    EXPECT_TRUE(channels != 11 ||
                draft.xml.contains("queue-length=\"11\"><Interface name=\"can1\"/>"))
        << draft.xml;
    EXPECT_FALSE(draft.xml.contains("ip link set can0")) << "nothing crosses to it";
    const Draft live = drafted(traffic.sent(), {.queue_lengths = {{"can1", 1000}}});
    EXPECT_EQ(live.xml.contains("queue-length=\"1000\""), channels > 10) << live.xml;
    EXPECT_FALSE(live.xml.contains("txqueuelen")) << "it is long enough as it is";
  }
}

/// A required Period without a Deadline asks for one of the Period, which a bus need not keep where
/// others send bursts.
TEST(Draft, BurstsOfManySendersAreGrantedWithDeadlinesThatTheBusCanKeep) {
  Traffic traffic(3);
  for (std::uint32_t n = 0; n < 12; ++n)
    traffic.bursts(0, (0x18f00000 + (n % 2 << 8U) + n) | kExtended, 8, 300'000, kSecond / 4, 60);
  traffic.periodic(0, 0x1ff00000 | kExtended, 5 * kMs, kMs / 10, 8, 60);
  const Draft draft = drafted(traffic.sent(), {.bitrates = {{"can0", 500'000}}}, {"can0"});
  EXPECT_EQ(refused_in(draft), 0U) << draft.xml;
  EXPECT_TRUE(draft.xml.contains(" deadline=\"")) << draft.xml;
}

/// A burst says how early events may be, not how often they come.
TEST(Draft, WhatCameSeldomAndInPairsReservesAboutWhatItTakes) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 24; ++i)
    sent.push_back({.ns = i / 2 * kSecond + i % 2 * 2 * kMs, .id = 0x123, .data = {1, 2}});
  const Draft draft = drafted(sent, {}, {"can0"});
  const auto& pairs = channel(draft, "can0-123");
  EXPECT_GE(pairs.period, 200 * kMs);
  EXPECT_GE(pairs.jitter, 200 * kMs);
  Gate gate(draft);
  for (const Sent& one : sent) EXPECT_TRUE(gate.passes(one));
}

TEST(Draft, TheSameTrafficGivesTheSameDraft) {
  EXPECT_EQ(drafted(two_buses(3, 20)).xml, drafted(two_buses(3, 20)).xml);
}

TEST(Draft, LearnedOnTheFirstHalfItDropsNothingOfTheSecond) {
  test::Share dropped;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto sent = two_buses(seed, 120);
    Gate gate(drafted(before(sent, 60 * kSecond)));
    // What crossed is sent by the gateway itself there.
    dropped += test::from(sent, 60 * kSecond, gate,
                          [](const Sent& one) { return one.interface == 0 || one.id == 0x3e8; });
  }
  EXPECT_GT(dropped.of, 60'000U);
  EXPECT_LT(dropped.frames * 1000, dropped.of) << dropped.frames << " of " << dropped.of;
}

TEST(Draft, AttacksAreDropped) {
  const auto sent = two_buses(7, 60);
  Gate gate(drafted(sent));
  const auto passing = [&](std::uint32_t id, std::size_t bytes, std::uint64_t gap, unsigned count) {
    unsigned passed = 0;
    for (unsigned i = 0; i < count; ++i)
      if (gate.passes({100 * kSecond + i * gap, 0, id, std::vector<std::uint8_t>(bytes)})) ++passed;
    return passed;
  };
  EXPECT_EQ(passing(0x123, 8, kMs, 1000), 0U) << "an unknown identifier";
  EXPECT_EQ(passing(0x1a0, 8, 20 * kMs, 100), 0U) << "a wrong length";
  EXPECT_LE(passing(0x100, 8, kMs / 5, 5000), 110U)
      << "a flood for a second: its 100 events, and the tolerance";
  EXPECT_EQ(passing(0x100 | kExtended, 8, 10 * kMs, 100), 0U) << "the other form of an identifier";
}

TEST(Draft, SendersOfJ1939ArePublishersOfOneChannel) {
  Traffic traffic(5);
  traffic.periodic(0, 0x0cf00400 | kExtended, 20 * kMs, kMs, 8, 30)
      .periodic(0, 0x0cf00403 | kExtended, 20 * kMs, kMs, 8, 30)
      .periodic(0, 0x18eeff00 | kExtended, kSecond, 0, 8, 30);
  const Draft draft = drafted(traffic.sent(), {}, {"can0"});
  ASSERT_EQ(draft.channels.size(), 1U) << "claims are control traffic";
  EXPECT_EQ(draft.channels[0].name, "can0-pgn-F004");
  EXPECT_EQ(draft.channels[0].publishers.size(), 2U);
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(Draft, ATransferOfCyphalOfSeveralFramesIsOneEvent) {
  std::vector<Sent> sent;
  std::uint8_t id = 0;
  for (int i = 0; i < 100; ++i, id = (id + 1) & 0x1f) {
    const std::uint64_t t = kSecond + static_cast<std::uint64_t>(i) * 50 * kMs;
    for (int part = 0; part < 3; ++part) {
      std::vector<std::uint8_t> data(part == 2 ? 3 : 7, 9);
      data.push_back(static_cast<std::uint8_t>((part == 0 ? 0x80 : 0) | (part == 2 ? 0x40 : 0) |
                                               (part % 2 == 0 ? 0x20 : 0) | id));
      sent.push_back(
          {t + static_cast<std::uint64_t>(part) * kMs / 4, 0, 0x107d552aU | kExtended, data});
    }
  }
  // 0x107d552a: subject 0x1d55 is the heart-beat of nodes; another one.
  for (Sent& one : sent) one.id = 0x1064d22aU | kExtended;
  const Draft draft = drafted(sent, {}, {"can0"});
  ASSERT_EQ(draft.channels.size(), 1U);
  EXPECT_EQ(draft.channels[0].events, 100U);
  EXPECT_EQ(draft.channels[0].period, 50 * kMs);
  EXPECT_EQ(draft.channels[0].bytes, 7U + 7U + 3U - 2U);
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(Draft, NamesThatADescriptionCannotHaveAreMadeOnes) {
  Traffic traffic(6);
  const Draft draft = drafted(traffic.periodic(0, 0x123, 10 * kMs, 0, 8, 2).sent(), {}, {"<0\"&>"});
  const auto system = described(draft);
  ASSERT_EQ(system.networks.size(), 1U);
  EXPECT_EQ(system.networks[0].name, "if_0___");
  EXPECT_EQ(system.gateways[0].ports[0].identity.name, "if_0___");
  const auto kernel = described(drafted({}, {}, {"0can.5@x+"}));
  EXPECT_EQ(kernel.gateways[0].ports[0].identity.name, "0can.5@x+");
}

TEST(Draft, WhateverARecordingCallsAnInterfaceTheDraftIsADescription) {
  for (const char* name : {"a--b", "-->", "--", "a-", "\xff\xfe", "<![CDATA[", "&x;"})
    EXPECT_EQ(described(drafted({}, {}, {name})).networks.size(), 1U) << name;
}

TEST(Draft, OfWhatCameOnceThePeriodIsAssumedAndSaidToBe) {
  const Draft draft = drafted({{kSecond, 0, 0x7df, {1, 2}}}, {}, {"can0"});
  ASSERT_EQ(draft.channels.size(), 1U);
  EXPECT_EQ(draft.channels[0].period, 100 * kMs);
  EXPECT_TRUE(draft.xml.contains("seen once: the Period is assumed")) << draft.xml;
  EXPECT_EQ(refused_in(draft), 0U);
}

TEST(Draft, ProgramsOfTheHostThatSendArePublishersOfTheGateway) {
  Traffic traffic(8);
  auto sent = traffic.periodic(0, 0x123, 10 * kMs, 0, 8, 5).sent();
  for (Sent& one : sent) one.local = true;
  const auto system = described(drafted(sent, {.user = "root"}, {"can0"}));
  ASSERT_EQ(system.publishers.size(), 1U);
  EXPECT_EQ(system.publishers[0].place.kind, core::Place::Kind::gateway);
  EXPECT_EQ(system.subscribers.at(0).place.kind, core::Place::Kind::network);
}

TEST(Draft, NothingThatWasSeenGivesADescriptionToo) {
  EXPECT_EQ(described(drafted({}, {}, {"can0"})).networks.size(), 1U);
  EXPECT_EQ(described(drafted({}, {}, {})).gateways.size(), 0U);
}

TEST(Draft, NamesThatNoInterfaceOfLinuxHasAreReplacedAndSaid) {
  const std::vector<std::string> names = {"body-control-left", "body-control-left-door",
                                          "body-control-lef", "can 3", "fifteen-letters"};
  Traffic traffic(1);
  for (std::uint32_t i = 0; i < names.size(); ++i)
    traffic.periodic(i, 0x100 + i, 20 * kMs, kMs / 2, 8, 10);
  const Draft draft = drafted(traffic.sent(), {}, names);
  const auto ports = described(draft).gateways.at(0).ports;
  std::vector<std::string> interfaces;
  for (const auto& port : ports) interfaces.push_back(port.identity.name);
  EXPECT_EQ(interfaces, (std::vector<std::string>{"body-control-le", "body-contro-2",
                                                  "body-contro-3", "can_3", "fifteen-letters"}));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string note = names[i] +
                             ": no interface of Linux has such a name (up to 15 letters, digits "
                             "and . _ - @ +): the Port has " +
                             interfaces[i] + " in its place; state the one that it is";
    EXPECT_EQ(std::ranges::count(draft.left_out, note), names[i] == interfaces[i] ? 0 : 1) << note;
  }
}

}  // namespace
}  // namespace mlcca::learn
