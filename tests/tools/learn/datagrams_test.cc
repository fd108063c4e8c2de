// SPDX-License-Identifier: BSD-2-Clause
// From Ethernet frames to datagrams, and from these to events of FAMOUSO.
#include "tools/learn/datagrams.hpp"

#include <gtest/gtest.h>

#include "relay/afp.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/ether.hpp"

namespace mlcca::learn {
namespace {

using core::Profile;
using test::event;
using test::kDistance;
using test::kMs;
using test::Sent;
using test::station;

using Payload = std::vector<std::uint8_t>;

// --- frames --------------------------------------------------------------------------------------

TEST(EthernetFrame, ADatagramIsFoundBehindUpToTwoTags) {
  const Sent sent = event(0, 0, kDistance, station(7), {1, 2, 3});
  for (unsigned tags = 0; tags <= 2; ++tags) {
    const Payload bytes = frame_of(sent, tags);
    Frame out;
    ASSERT_EQ(read_ethernet(bytes, out), Carries::datagram) << tags;
    EXPECT_EQ(out.datagram->source, station(7));
    EXPECT_EQ(out.datagram->port, 9999);
    EXPECT_EQ(out.datagram->bytes, 12U);
    EXPECT_EQ(out.datagram->mac, sent.datagram->mac);
    EXPECT_EQ(Payload(out.data.begin(), out.data.end()), sent.data);
  }
  Frame out;
  EXPECT_EQ(read_ethernet(frame_of(sent, 3), out), Carries::other);
}

TEST(EthernetFrame, PaddingIsNoDataAndWhatWasCutOffIsCounted) {
  const Sent sent = event(0, 0, kDistance, station(7), Payload(100));
  Payload bytes = frame_of(sent);
  bytes.insert(bytes.end(), 20, 0xee);
  Frame out;
  ASSERT_EQ(read_ethernet(bytes, out), Carries::datagram);
  EXPECT_EQ(out.data.size(), 109U);
  bytes.resize(64);
  ASSERT_EQ(read_ethernet(bytes, out), Carries::datagram);
  EXPECT_EQ(out.data.size(), 64U - 42U);
  EXPECT_EQ(out.datagram->bytes, 109U);
}

TEST(EthernetFrame, OfIpFragmentsTheFirstOneSaysTheLengthOfAll) {
  Payload bytes = frame_of(event(0, 0, kDistance, station(7), Payload(1463)));
  bytes[20] = 0x20;       // more fragments
  bytes[38] = 4000 >> 8;  // length that UDP states
  bytes[39] = 4000 & 0xff;
  Frame out;
  ASSERT_EQ(read_ethernet(bytes, out), Carries::datagram);
  EXPECT_EQ(out.datagram->bytes, 3992U);
  bytes[20] = 0x20;
  bytes[21] = 100;
  EXPECT_EQ(read_ethernet(bytes, out), Carries::other) << "a later fragment";
}

TEST(EthernetFrame, OtherTrafficIsNoneAndBrokenHeadersAreSaid) {
  const Payload good = frame_of(event(0, 0, kDistance, station(7), {1}));
  const auto with = [&](std::size_t at, std::uint8_t value) {
    Payload bytes = good;
    bytes[at] = value;
    Frame out;
    return read_ethernet(bytes, out);
  };
  EXPECT_EQ(with(12, 0x86), Carries::other) << "another ethertype";
  EXPECT_EQ(with(23, 6), Carries::other) << "TCP";
  EXPECT_EQ(with(14, 0x65), Carries::broken) << "version 6 in a packet of IPv4";
  EXPECT_EQ(with(14, 0x44), Carries::broken) << "a header of 16 bytes";
  EXPECT_EQ(with(17, 20), Carries::broken) << "nothing behind the header";
  EXPECT_EQ(with(39, 200), Carries::broken) << "UDP says more than IP";
  EXPECT_EQ(with(39, 3), Carries::broken) << "less than a header of UDP";
  for (std::size_t size = 0; size < good.size(); ++size) {
    Frame out;
    const Payload cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(read_ethernet(cut, out), size < 42 ? Carries::broken : Carries::datagram) << size;
  }
}

// --- events --------------------------------------------------------------------------------------

struct Taken {
  Datagrams datagrams;
  std::vector<Event> events;
  std::vector<Payload> heads;
  void take(const Sent& sent) {
    datagrams.take(sent.frame(), [&](const Event& event) {
      events.push_back(event);
      heads.emplace_back(event.head.begin(), event.head.end());
    });
  }
};

TEST(Datagrams, AnEventHasItsSubjectItsSenderAndItsLength) {
  Taken taken;
  taken.take(event(42, 0, kDistance, station(7), {1, 2, 3}));
  Sent local = event(43, 0, kDistance, station(1), {});
  local.local = true;
  taken.take(local);
  ASSERT_EQ(taken.events.size(), 2U);
  EXPECT_EQ(taken.events[0].ns, 42U);
  EXPECT_EQ(taken.events[0].number, kDistance);
  EXPECT_EQ(taken.events[0].node, station(7));
  EXPECT_EQ(taken.events[0].bytes, 3U);
  EXPECT_EQ(taken.heads[0], (Payload{1, 2, 3}));
  EXPECT_TRUE(taken.events[1].local);
  EXPECT_EQ(taken.events[1].node, 0U) << "programs of this host are one";
  EXPECT_EQ(taken.events[1].bytes, 0U) << "an event may be empty";
  EXPECT_EQ(taken.datagrams.recognised().profile, Profile::famouso);
  EXPECT_EQ(taken.datagrams.recognised().percent, 99U);
}

TEST(Datagrams, FragmentsAreOneEventWhateverOrderTheyComeIn) {
  Payload data(20'000);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i);
  for (const bool reversed : {false, true}) {
    Taken taken;
    std::vector<Sent> sent;
    auto fragments = relay::afp::Fragments::of(relay::afp::kUdp, data, 5);
    while (const auto fragment = fragments->next())
      sent.push_back(event(7, 0, kDistance, station(7), *fragment, true));
    ASSERT_EQ(sent.size(), 3U);
    if (reversed) std::ranges::reverse(sent);
    for (const Sent& one : sent) {
      // As an IP fragment has it: the beginning, and how long all is.
      Sent first = one;
      first.data.resize(1472);
      taken.take(first);
    }
    ASSERT_EQ(taken.events.size(), 1U);
    EXPECT_EQ(taken.events[0].bytes, 20'000U);
    EXPECT_EQ(taken.heads[0], Payload(data.begin(), data.begin() + 64));
  }
}

TEST(Datagrams, OfAnEventOfWhichAFragmentIsMissingNothingComes) {
  Taken taken;
  for (std::uint32_t number = 0; number < 2000; ++number) {
    auto fragments = relay::afp::Fragments::of(relay::afp::kUdp, Payload(9000), number);
    taken.take(event(number * kMs, 0, kDistance, station(7), *fragments->next(), true));
  }
  EXPECT_TRUE(taken.events.empty());
  EXPECT_GE(taken.datagrams.incomplete(), 1900U) << "memory is bounded";
}

TEST(Datagrams, WhatWasCutOffTooEarlyHasNoContentToCompare) {
  Taken taken;
  Sent sent = event(0, 0, kDistance, station(7), Payload(200, 1));
  sent.data.resize(40);
  taken.take(sent);
  ASSERT_EQ(taken.events.size(), 1U);
  EXPECT_EQ(taken.events[0].bytes, 200U);
  EXPECT_EQ(taken.heads[0].size(), 31U);
}

TEST(Datagrams, SubscriptionsAndManagementAreControlTraffic) {
  Taken taken;
  taken.take(event(0, 0, 0x5355425343524942, station(7), Payload(8)));
  taken.take(event(0, 0, 0x4d616e4368616e21, station(7), Payload(8)));
  EXPECT_TRUE(taken.events.empty());
  EXPECT_EQ(taken.datagrams.control(), 2U);
  EXPECT_EQ(taken.datagrams.management(), 1U);
}

TEST(Datagrams, WhatIsNoEventIsCounted) {
  Taken taken;
  Sent sent = event(0, 0, kDistance, station(7), {1});
  sent.data[8] = 2;
  taken.take(sent);
  sent.data.resize(8);
  sent.datagram->bytes = 8;
  taken.take(sent);
  for (const std::uint32_t nobody : {0U, 0x7f000001U, 0xe0000001U, 0xffffffffU})
    taken.take(event(0, 0, kDistance, nobody, {1}));
  taken.take(event(0, 0, 0, station(7), {1}));
  taken.take(event(0, 0, kDistance, station(7), Payload(8184)));
  EXPECT_TRUE(taken.events.empty());
  EXPECT_EQ(taken.datagrams.malformed(), 8U);
  EXPECT_EQ(taken.datagrams.recognised().profile, Profile::none);
}

TEST(Datagrams, OtherTrafficIsCountedByTheSmallerOfItsPorts) {
  Taken taken;
  for (std::uint16_t i = 0; i < 1000; ++i) {
    Sent sent = event(0, 0, kDistance, station(7), {1});
    sent.datagram->port = i % 2 == 0 ? 53 : static_cast<std::uint16_t>(20'000 + i);
    sent.datagram->source_port = i % 2 == 0 ? static_cast<std::uint16_t>(30'000 + i)
                                            : static_cast<std::uint16_t>(10'100 + i);
    taken.take(sent);
  }
  EXPECT_TRUE(taken.events.empty());
  EXPECT_EQ(taken.datagrams.others(), 1000U);
  EXPECT_TRUE(taken.datagrams.other_ports().starts_with("port 53 (500), "))
      << taken.datagrams.other_ports();
  EXPECT_TRUE(taken.datagrams.other_ports().ends_with(", others (493)"))
      << taken.datagrams.other_ports();
  EXPECT_EQ(taken.datagrams.recognised().profile, Profile::none);
}

TEST(Datagrams, ItIsLessSureWhereNoDatagramGoesToTheGroupOfItsSubject) {
  Taken taken;
  Sent sent = event(0, 0, kDistance, station(7), {1});
  sent.datagram->destination = 0xffffffff;
  sent.datagram->port = 8888;
  taken.take(sent);
  const auto is = taken.datagrams.recognised();
  EXPECT_EQ(is.profile, Profile::famouso);
  EXPECT_EQ(is.percent, 70U);
  EXPECT_TRUE(is.why.contains("none went to the multicast group")) << is.why;
}

TEST(Datagrams, MostlyOtherThingsOnThePortsAreNotFamouso) {
  Taken taken;
  taken.take(event(0, 0, kDistance, station(7), {1}));
  for (int i = 0; i < 9; ++i) {
    Sent sent = event(0, 0, kDistance, station(7), {1});
    sent.data[8] = 77;
    taken.take(sent);
  }
  EXPECT_EQ(taken.datagrams.recognised().profile, Profile::none);
  EXPECT_TRUE(taken.datagrams.recognised().why.contains("10 % of 10 datagrams"));
}

}  // namespace
}  // namespace mlcca::learn
