// SPDX-License-Identifier: BSD-2-Clause
// From what the kernel reports of radios, batman-adv and wires to samples of links.
#include <gtest/gtest.h>
#include <linux/nl80211.h>

#include <algorithm>
#include <string>

#include "daemon/net/sources/batman.hpp"
#include "daemon/net/sources/nl80211_view.hpp"
#include "daemon/net/sources/wire.hpp"

namespace mlcca::net {
namespace {

using core::mesh::RateKind;
using core::mesh::Sample;
using core::mesh::Snapshot;

constexpr const char* kOwn = "02:00:00:00:00:00";
constexpr const char* kPeer = "02:00:00:00:01:00";
constexpr const char* kFar = "02:00:00:00:02:00";
constexpr std::uint64_t kNow = 100'000'000'000;  // ns

const Sample* find(const Snapshot& snapshot, const std::string& from, const std::string& to) {
  const auto it = std::ranges::find_if(
      snapshot.links, [&](const Sample& s) { return s.from == from && s.to == to; });
  return it == snapshot.links.end() ? nullptr : &*it;
}

class RadioView : public ::testing::Test {
 protected:
  RadioView() {
    seen.interface = {.mac = kOwn, .mesh = true, .frequency = 2412};
    nl80211::Station peer;
    peer.mac = kPeer;
    peer.plink_state = NL80211_PLINK_ESTAB;
    peer.tx_bitrate = 13'000'000;
    peer.rx_bitrate = 26'000'000;
    peer.expected_throughput = 9'704'000;
    peer.tx_packets = 100;
    peer.tx_failed = 0;
    peer.inactive = 384;
    seen.stations.push_back(peer);
  }
  nl80211::Station& peer() { return seen.stations.front(); }
  Sample there() {
    const Snapshot snapshot = view.update(seen, kNow);
    const Sample* const found = find(snapshot, kOwn, kPeer);
    EXPECT_NE(found, nullptr);
    return found == nullptr ? Sample{} : *found;
  }
  Sample back() {
    const Snapshot snapshot = view.update(seen, kNow);
    const Sample* const found = find(snapshot, kPeer, kOwn);
    EXPECT_NE(found, nullptr);
    return found == nullptr ? Sample{} : *found;
  }
  nl80211::Seen seen;
  nl80211::View view;
};

TEST_F(RadioView, APeerIsALinkInBothDirections) {
  const Snapshot snapshot = view.update(seen, kNow);
  ASSERT_EQ(snapshot.links.size(), 2U);
  const Sample* const to = find(snapshot, kOwn, kPeer);
  const Sample* const from = find(snapshot, kPeer, kOwn);
  ASSERT_TRUE(to != nullptr && from != nullptr);
  EXPECT_EQ(to->rate, 9'704'000U);
  EXPECT_EQ(to->kind, RateKind::effective);
  EXPECT_EQ(from->rate, 26'000'000U);
  EXPECT_EQ(from->kind, RateKind::phy);
  EXPECT_EQ(to->channel, 2412U);
  EXPECT_EQ(from->channel, 2412U);
  EXPECT_FALSE(from->loss) << "the loss of the other direction is not seen here";
}

TEST_F(RadioView, WithoutAnExpectedThroughputTheBitRateCounts) {
  peer().expected_throughput.reset();
  const Sample link = there();
  EXPECT_EQ(link.rate, 13'000'000U);
  EXPECT_EQ(link.kind, RateKind::phy);
}

TEST_F(RadioView, TheAgeIsTheTimeSinceThePeerWasReceived) {
  EXPECT_EQ(there().taken, kNow - 384'000'000);
  peer().inactive = 4'000'000;  // longer than this machine runs
  EXPECT_EQ(there().taken, 0U);
  peer().inactive.reset();
  EXPECT_EQ(there().taken, kNow);
}

TEST_F(RadioView, OnlyEstablishedPeersAreLinksOfAMesh) {
  for (const std::uint8_t state : {NL80211_PLINK_LISTEN, NL80211_PLINK_OPN_SNT,
                                   NL80211_PLINK_HOLDING, NL80211_PLINK_BLOCKED}) {
    peer().plink_state = state;
    EXPECT_TRUE(view.update(seen, kNow).links.empty());
  }
  peer().plink_state.reset();
  EXPECT_TRUE(view.update(seen, kNow).links.empty());
  seen.interface.mesh = false;  // ad hoc: there are no peerings
  EXPECT_EQ(view.update(seen, kNow).links.size(), 2U);
}

TEST_F(RadioView, ASlowerBitRateOutweighsTheExpectationWhenItLasts) {
  EXPECT_EQ(there().kind, RateKind::effective);
  peer().tx_bitrate = 1'000'000;
  for (int poll = 0; poll < 2; ++poll) {
    peer().tx_packets = *peer().tx_packets + 5;
    EXPECT_EQ(there().kind, RateKind::effective) << "it may have tried a rate out";
    EXPECT_TRUE(view.unconfirmed());
  }
  peer().tx_packets = *peer().tx_packets + 5;
  const Sample slow = there();
  EXPECT_EQ(slow.rate, 1'000'000U);
  EXPECT_EQ(slow.kind, RateKind::phy);
  EXPECT_FALSE(view.unconfirmed());
  EXPECT_EQ(there().rate, 1'000'000U) << "without new packets nothing is known better";
  peer().tx_bitrate = 13'000'000;
  EXPECT_EQ(there().rate, 9'704'000U);
}

TEST_F(RadioView, ASlowFrameThatStaysTheLastProvesNothing) {
  peer().tx_bitrate = 1'000'000;
  EXPECT_EQ(there().kind, RateKind::effective);
  EXPECT_TRUE(view.unconfirmed());
  for (int poll = 0; poll < 5; ++poll) {
    EXPECT_EQ(there().kind, RateKind::effective);
    EXPECT_FALSE(view.unconfirmed()) << "nothing was sent: polling again would not show it";
  }
}

TEST_F(RadioView, AFastFrameBetweenSlowOnesEndsTheDoubt) {
  for (int poll = 0; poll < 10; ++poll) {
    peer().tx_bitrate = poll % 3 == 2 ? 13'000'000 : 1'000'000;
    peer().tx_packets = *peer().tx_packets + 5;
    EXPECT_EQ(there().kind, RateKind::effective);
  }
}

TEST_F(RadioView, LossIsTheShareOfPacketsGivenUp) {
  EXPECT_FALSE(there().loss) << "one poll gives no difference";
  peer().tx_packets = 200;
  peer().tx_failed = 7;
  EXPECT_EQ(there().loss, 70'000'000U);  // 7 of 100
}

TEST_F(RadioView, FewPacketsReportNoLoss) {
  static_cast<void>(there());
  peer().tx_packets = 119;
  peer().tx_failed = 10;
  EXPECT_FALSE(there().loss);
  peer().tx_packets = 120;
  EXPECT_EQ(there().loss, 500'000'000U);
}

TEST_F(RadioView, OldLossIsForgotten) {
  static_cast<void>(there());
  peer().tx_packets = 200;
  peer().tx_failed = 50;
  EXPECT_EQ(there().loss, 500'000'000U);
  for (int poll = 0; poll < 9; ++poll) {
    peer().tx_packets = *peer().tx_packets + 100;
    EXPECT_GT(there().loss, 0U);
  }
  peer().tx_packets = *peer().tx_packets + 100;
  EXPECT_EQ(there().loss, 0U) << "ten polls ago";
}

TEST_F(RadioView, CountersThatStartAgainReportNoLoss) {
  static_cast<void>(there());
  peer().tx_packets = 30;
  EXPECT_FALSE(there().loss);
  peer().tx_packets = 60;
  EXPECT_EQ(there().loss, 0U);
}

TEST_F(RadioView, MoreFailuresThanPacketsIsAll) {
  // A driver that counts a packet only when it got through.
  static_cast<void>(there());
  peer().tx_packets = 120;
  peer().tx_failed = 60;
  EXPECT_EQ(there().loss, 1'000'000'000U);
}

TEST_F(RadioView, APeerThatCameBackStartsAgain) {
  static_cast<void>(there());
  const auto before = seen.stations;
  seen.stations.clear();
  EXPECT_TRUE(view.update(seen, kNow).links.empty());
  seen.stations = before;
  peer().tx_packets = 200;
  peer().tx_failed = 100;
  EXPECT_FALSE(there().loss);
}

TEST_F(RadioView, BusyIsTheShareOfTheChannelInUse) {
  seen.surveys = {{.frequency = 2437, .in_use = false, .time = 5000, .busy = 5000},
                  {.frequency = 2412, .in_use = true, .time = 10'000, .busy = 400}};
  EXPECT_FALSE(there().busy);
  seen.surveys[1].time = 11'000;
  seen.surveys[1].busy = 650;
  EXPECT_EQ(there().busy, 250'000U);
  seen.surveys[1].time = 12'000;
  seen.surveys[1].busy = 950;
  EXPECT_FALSE(back().busy) << "how busy it is around the peer is not known here";
}

TEST_F(RadioView, WhatThisRadioSendsIsNotTakenByOthers) {
  seen.surveys = {{.frequency = 2412, .in_use = true, .time = 10'000, .busy = 400, .sent = 300}};
  EXPECT_FALSE(there().busy);
  seen.surveys[0] = {.frequency = 2412, .in_use = true, .time = 11'000, .busy = 650, .sent = 450};
  EXPECT_EQ(there().busy, 100'000U);
}

TEST_F(RadioView, ASurveyThatDoesNotCountReportsNothing) {
  seen.surveys = {{.frequency = 2412, .in_use = true, .time = 10'000, .busy = 400}};
  for (int poll = 0; poll < 4; ++poll) EXPECT_FALSE(there().busy);
  seen.surveys[0].time = 10'499;
  EXPECT_FALSE(there().busy) << "less than half a second";
}

TEST_F(RadioView, AnotherChannelStartsAgain) {
  seen.surveys = {{.frequency = 2412, .in_use = true, .time = 10'000, .busy = 400}};
  static_cast<void>(there());
  seen.surveys = {{.frequency = 2437, .in_use = true, .time = 20'000, .busy = 9'400}};
  EXPECT_FALSE(there().busy);
}

TEST_F(RadioView, MeshPathsReportNextHopsOnly) {
  seen.paths = {{.destination = kPeer,
                 .next_hop = kPeer,
                 .metric = 820,
                 .hops = 1,
                 .flags = NL80211_MPATH_FLAG_ACTIVE},
                {.destination = kFar,
                 .next_hop = kPeer,
                 .metric = 1087,
                 .hops = 2,
                 .flags = NL80211_MPATH_FLAG_ACTIVE | NL80211_MPATH_FLAG_RESOLVED},
                {.destination = "02:00:00:00:03:00",
                 .next_hop = kPeer,
                 .metric = 5,
                 .hops = 1,
                 .flags = NL80211_MPATH_FLAG_RESOLVING}};
  const Snapshot snapshot = view.update(seen, kNow);
  const std::vector<core::mesh::NextHop> expected{{.from = kOwn, .to = kPeer, .via = kPeer},
                                                  {.from = kOwn, .to = kFar, .via = kPeer}};
  EXPECT_EQ(snapshot.next_hops, expected);
  EXPECT_EQ(snapshot.links.size(), 2U) << "a path of two hops is no link";
}

TEST_F(RadioView, ADirectPathsMetricIsARateWhereTheDriverReportsNone) {
  peer().expected_throughput.reset();
  peer().tx_bitrate.reset();
  EXPECT_EQ(there().rate, 0U) << "known, its rate is not";
  // 24 Mbit/s: 1 + 8192/24 = 342.33; back: 8192/341 = 24.0235 Mbit/s.
  seen.paths = {{.destination = kPeer,
                 .next_hop = kPeer,
                 .metric = 342,
                 .hops = 1,
                 .flags = NL80211_MPATH_FLAG_ACTIVE}};
  const Sample link = there();
  EXPECT_EQ(link.rate, 8'192'000'000U / 341);
  EXPECT_EQ(link.kind, RateKind::derived);
  seen.paths[0].hops = 2;
  EXPECT_EQ(there().rate, 0U);
}

TEST(RadioMetric, NoLinkHasNoRate) {
  EXPECT_FALSE(nl80211::rate_of_metric(0));
  EXPECT_FALSE(nl80211::rate_of_metric(1));
  EXPECT_FALSE(nl80211::rate_of_metric(0xffffffff));
  EXPECT_EQ(nl80211::rate_of_metric(257), 32'000'000U);  // the example of open80211s
}

TEST(BatmanView, ANeighboursThroughputIsALinkFromTheInterfaceItIsReceivedOn) {
  const batman::Seen seen{
      .interfaces = {{.index = 4, .mac = kOwn}},
      .neighbours = {{.mac = kPeer, .interface = 4, .throughput = 8'500'000, .last_seen = 120},
                     {.mac = kFar, .interface = 9, .throughput = 1'000'000, .last_seen = 0}},
      .originators = {
          {.mac = kFar, .next_hop = kPeer, .interface = 4, .best = true, .quality = {}},
          {.mac = kFar, .next_hop = kFar, .interface = 4, .best = false, .quality = {}}}};
  const Snapshot snapshot = batman::view(seen, kNow);
  ASSERT_EQ(snapshot.links.size(), 2U) << "an interface that went has no links";
  const Sample& back = snapshot.links[1];
  EXPECT_EQ(back.from, kPeer);
  EXPECT_EQ(back.to, kOwn);
  EXPECT_EQ(back.rate, 0U) << "it is there, and what it carries only the neighbour knows";
  EXPECT_EQ(back.taken, kNow - 120'000'000);
  const Sample& link = snapshot.links.front();
  EXPECT_EQ(link.from, kOwn);
  EXPECT_EQ(link.to, kPeer);
  EXPECT_EQ(link.rate, 8'500'000U);
  EXPECT_EQ(link.kind, RateKind::effective);
  EXPECT_EQ(link.taken, kNow - 120'000'000);
  EXPECT_FALSE(link.loss);
  const std::vector<core::mesh::NextHop> expected{{.from = kOwn, .to = kFar, .via = kPeer}};
  EXPECT_EQ(snapshot.next_hops, expected);
}

TEST(BatmanView, BatmanIvReportsLossWithoutARate) {
  const batman::Seen seen{
      .interfaces = {{.index = 4, .mac = kOwn}},
      .neighbours = {{.mac = kPeer, .interface = 4, .throughput = {}, .last_seen = 0}},
      .originators = {
          {.mac = kPeer, .next_hop = kPeer, .interface = 4, .best = true, .quality = 204}}};
  const Snapshot snapshot = batman::view(seen, kNow);
  ASSERT_EQ(snapshot.links.size(), 2U);
  EXPECT_EQ(snapshot.links.front().rate, 0U);
  EXPECT_EQ(snapshot.links.front().loss, 200'000'000U);  // 1 - 204/255 = 0.2
}

TEST(WireView, LeadsToEveryOtherNode) {
  const wire::Interface interface{.mac = kOwn, .index = 7, .running = true};
  const Snapshot snapshot = wire::view(interface, {.speed = 1'000'000'000, .half_duplex = false},
                                       {kPeer, kOwn, kFar}, kNow);
  ASSERT_EQ(snapshot.links.size(), 4U);
  const Sample* const out = find(snapshot, kOwn, kPeer);
  const Sample* const other = find(snapshot, kOwn, kFar);
  const Sample* const in = find(snapshot, kPeer, kOwn);
  ASSERT_TRUE(out != nullptr && other != nullptr && in != nullptr);
  EXPECT_EQ(out->rate, 1'000'000'000U);
  EXPECT_EQ(out->kind, RateKind::phy);
  EXPECT_EQ(out->taken, kNow);
  EXPECT_EQ(out->channel, other->channel) << "one wire leads to both";
  EXPECT_NE(out->channel, in->channel) << "full duplex";
}

TEST(WireView, HalfDuplexSharesTheTimeOfBothDirections) {
  const wire::Interface interface{.mac = kOwn, .index = 7, .running = true};
  const Snapshot snapshot =
      wire::view(interface, {.speed = 10'000'000, .half_duplex = true}, {kPeer}, kNow);
  ASSERT_EQ(snapshot.links.size(), 2U);
  EXPECT_EQ(snapshot.links[0].channel, snapshot.links[1].channel);
}

TEST(WireView, WithoutACarrierThereIsNoLinkAndWithoutASpeedNoRate) {
  const wire::Interface down{.mac = kOwn, .index = 7, .running = false};
  EXPECT_TRUE(wire::view(down, {.speed = 10'000'000}, {kPeer}, kNow).links.empty());
  const wire::Interface up{.mac = kOwn, .index = 7, .running = true};
  const Snapshot snapshot = wire::view(up, {}, {kPeer}, kNow);
  ASSERT_EQ(snapshot.links.size(), 2U);
  EXPECT_EQ(snapshot.links[0].rate, 0U);
}

}  // namespace
}  // namespace mlcca::net
