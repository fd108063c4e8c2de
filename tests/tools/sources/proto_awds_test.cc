// SPDX-License-Identifier: BSD-2-Clause
// Topology packets of AWDS: what is read from their octets, what the qualities mean, and how the
// graph ages.
#include <gtest/gtest.h>

#include <random>

#include "tests/tools/sources/proto_emulated.hpp"
#include "tests/tools/sources/proto_loop.hpp"
#include "tools/sources/awds_packet.hpp"

namespace mlcca::net::awds {
namespace {

using core::mesh::AwdsMetric;
using core::mesh::RateKind;
using test::octets;

constexpr std::uint64_t kMilli = 1'000'000;

/// Taken off the air: node 2 of the chain 1 - 2 - 3, hop count metric.
const char* const kCaptured =
    "01 020000000002 0033 020000000002 20 00 00000e10 02"
    "020000000001 0001 020000000003 0001 05 6e6f646532";

NodeId id(std::uint8_t number) { return {2, 0, 0, 0, 0, number}; }

Topology topology(std::uint8_t source, std::uint16_t sequence, std::uint32_t validity,
                  std::vector<Neighbour> neighbours) {
  return {.source = id(source),
          .sequence = sequence,
          .validity = validity,
          .neighbours = std::move(neighbours),
          .name = {}};
}

TEST(AwdsPacket, ACapturedPacketIsReadOctetByOctet) {
  const auto read = parse(octets(kCaptured));
  ASSERT_TRUE(read);
  const Topology expected{.source = id(2),
                          .sequence = 0x33,
                          .validity = 3600,
                          .neighbours = {{id(1), 1}, {id(3), 1}},
                          .name = "node2"};
  EXPECT_EQ(*read, expected);
  EXPECT_EQ(address_of(read->source), "02:00:00:00:00:02");
}

TEST(AwdsPacket, TheEmulatorSendsWhatWasCaptured) {
  EXPECT_EQ(test::topology({.node = 2,
                            .sequence = 0x33,
                            .last_hop = 2,
                            .ttl = 32,
                            .validity_ms = 3600,
                            .qualities = {{1, 1}, {3, 1}},
                            .name = "node2"}),
            octets(kCaptured));
  EXPECT_EQ(test::beacon(1, 0x2c, 1400, {2}),
            octets("00 020000000001 002c 0578 00 01 020000000002"));
}

TEST(AwdsPacket, TheTraceFlagAndASignatureBehindTheNameChangeNothing) {
  auto packet = octets(kCaptured);
  const auto plain = parse(packet);
  packet[0] = 0x81;
  EXPECT_EQ(parse(packet), plain);
  packet.resize(packet.size() + 32, 0xa5);
  EXPECT_EQ(parse(packet), plain);
}

TEST(AwdsPacket, OtherPacketsAreNotTopology) {
  EXPECT_FALSE(parse(octets("00 020000000001 002c 0578 00 01 020000000002")));  // beacon
  // Ping, and a flood that carries an Ethernet frame (98).
  EXPECT_FALSE(parse(octets("82 020000000001 0004 020000000003 020000000002 40 2a 0028 69")));
  auto data = octets(kCaptured);
  data[16] = 98;
  EXPECT_FALSE(parse(data));
}

TEST(AwdsPacket, APacketThatIsCutOffAnywhereIsNoPacket) {
  const auto packet = octets(kCaptured);
  for (std::size_t size = 0; size < packet.size(); ++size)
    EXPECT_FALSE(parse(std::span(packet).first(size))) << size;
}

TEST(AwdsPacket, TheShortestOneHasNeitherLinksNorName) {
  const auto packet = octets("01 020000000001 0001 020000000001 20 00 00000e10 00 00");
  EXPECT_EQ(packet.size(), kShortest);
  ASSERT_TRUE(parse(packet));
  EXPECT_TRUE(parse(packet)->neighbours.empty());
}

TEST(AwdsPacket, CountsOutsideTheProtocolAreRefused) {
  auto packet = octets(kCaptured);
  packet[21] = 41;
  packet.resize(1000);
  EXPECT_FALSE(parse(packet));
  packet = octets("01 020000000001 0001 020000000001 20 00 00000e10 00 21");
  packet.resize(1000, 'x');
  EXPECT_FALSE(parse(packet));  // a name of 33
}

TEST(AwdsPacket, ANeighbourTwiceOrTheSenderItselfIsRefused) {
  auto twice = octets(kCaptured);
  twice[22 + 8 + 5] = 1;
  EXPECT_FALSE(parse(twice));
  auto itself = octets(kCaptured);
  itself[22 + 5] = 2;
  EXPECT_FALSE(parse(itself));
}

TEST(AwdsPacket, RandomOctetsAreSurvivedAndWhatIsReadFits) {
  std::mt19937 random(4);
  std::uniform_int_distribution<unsigned> octet(0, 255);
  const auto captured = octets(kCaptured);
  for (int round = 0; round < 200'000; ++round) {
    // Exactly as long as it is, so that a sanitizer sees every octet read after it.
    std::vector<std::uint8_t> packet = captured;
    if (round % 2 == 0) packet.resize(octet(random));
    for (unsigned i = octet(random) % 4 + 1; i > 0 && !packet.empty(); --i)
      packet[octet(random) % packet.size()] = static_cast<std::uint8_t>(octet(random));
    const auto read = parse(packet);
    if (!read) continue;
    EXPECT_LE(22 + 8 * read->neighbours.size() + 1 + read->name.size(), packet.size());
  }
}

TEST(AwdsQuality, EtxIsTheLossTowardsTheReporter) {
  // 27 of 32 beacons of node 3 came through to node 2.
  const auto sample = sample_of(AwdsMetric::etx, id(2), {id(3), 0x27fb});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->from, "02:00:00:00:00:03");
  EXPECT_EQ(sample->to, "02:00:00:00:00:02");
  EXPECT_EQ(sample->rate, 0U);
  EXPECT_EQ(sample->loss, 156'250'000U);  // 5/32
  EXPECT_EQ(sample_of(AwdsMetric::etx, id(2), {id(3), 1})->loss, 0U);
  EXPECT_EQ(sample_of(AwdsMetric::etx, id(2), {id(3), 65504})->loss, 1'000'000'000U);
}

TEST(AwdsQuality, WhatEtxCannotHaveSentSaysNothing) {
  for (const int quality : {0, 10, 2046, 2048, 65505, 65535})
    EXPECT_FALSE(sample_of(AwdsMetric::etx, id(2), {id(3), static_cast<std::uint16_t>(quality)}))
        << quality;
}

TEST(AwdsQuality, APairOfPacketsIsARateTowardsTheNeighbour) {
  const auto sample = sample_of(AwdsMetric::packet_pair, id(2), {id(3), 175});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->from, "02:00:00:00:00:02");
  EXPECT_EQ(sample->to, "02:00:00:00:00:03");
  EXPECT_EQ(sample->kind, RateKind::effective);
  EXPECT_FALSE(sample->loss);
  EXPECT_EQ(sample->rate, 23'967'085U);  // 4194.24 Mbit/s / 175
  EXPECT_EQ(sample_of(AwdsMetric::packet_pair, id(2), {id(3), 381})->rate, 11'008'503U);
  EXPECT_EQ(sample_of(AwdsMetric::packet_pair, id(2), {id(3), 4194})->rate, 1'000'057U);
}

TEST(AwdsQuality, ATransmissionTimeIsTenTimesAsCoarse) {
  EXPECT_EQ(sample_of(AwdsMetric::transmission_time, id(2), {id(3), 175})->rate, 2'396'708U);
}

TEST(AwdsQuality, ALinkThatWasNeverProbedHasNoRate) {
  for (const auto metric : {AwdsMetric::packet_pair, AwdsMetric::transmission_time})
    EXPECT_EQ(sample_of(metric, id(2), {id(3), 0xffff})->rate, 0U);
}

TEST(AwdsQuality, AHopIsALinkAndNothingElse) {
  const auto sample = sample_of(AwdsMetric::hops, id(2), {id(3), 10});
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->rate, 0U);
  EXPECT_FALSE(sample->loss);
}

TEST(AwdsQuality, WeightsAreThoseOfAwds) {
  EXPECT_EQ(weight_of(AwdsMetric::hops, 10, 10), 1U);
  // 18 and 19 of 32: a running AWDS showed 0x17f4.
  EXPECT_EQ(weight_of(AwdsMetric::etx, 14 * 2047, 13 * 2047), 0x17f4U);
  EXPECT_EQ(weight_of(AwdsMetric::etx, 1, 1), 2048U);
  EXPECT_EQ(weight_of(AwdsMetric::packet_pair, 175, 381), 556U);
  EXPECT_EQ(weight_of(AwdsMetric::transmission_time, 175, 381), 175U);
  EXPECT_EQ(weight_of(AwdsMetric::etx, 1, std::nullopt), 4'194'303U);
  EXPECT_EQ(weight_of(AwdsMetric::etx, 65504, 1), 4'194'303U);
}

TEST(AwdsGraph, CopiesOfAFloodCountOnce) {
  Graph graph(AwdsMetric::etx);
  EXPECT_TRUE(graph.take(topology(1, 7, 3600, {{id(2), 1}}), 1000));
  EXPECT_FALSE(graph.take(topology(1, 7, 3600, {{id(2), 2047}}), 2000));
  EXPECT_FALSE(graph.take(topology(1, 6, 3600, {{id(2), 2047}}), 2000));
  const auto snapshot = graph.snapshot(3000);
  ASSERT_EQ(snapshot.links.size(), 1U);
  EXPECT_EQ(snapshot.links[0].loss, 0U);
  EXPECT_EQ(snapshot.links[0].taken, 1000U);
  EXPECT_EQ(snapshot.links[0].valid, 3600 * kMilli);
}

TEST(AwdsGraph, SequenceNumbersWrap) {
  Graph graph(AwdsMetric::etx);
  EXPECT_TRUE(graph.take(topology(1, 0xffff, 3600, {}), 0));
  EXPECT_TRUE(graph.take(topology(1, 0, 3600, {}), 1));
  EXPECT_FALSE(graph.take(topology(1, 0xffff, 3600, {}), 2));
}

TEST(AwdsGraph, WhatIsNotRepeatedExpires) {
  Graph graph(AwdsMetric::hops);
  graph.take(topology(1, 1, 1000, {{id(2), 10}}), 0);
  graph.take(topology(2, 1, 2000, {{id(1), 10}}), 0);
  EXPECT_EQ(graph.snapshot(1000 * kMilli - 1).links.size(), 2U);
  const auto later = graph.snapshot(1000 * kMilli);
  ASSERT_EQ(later.links.size(), 1U);
  EXPECT_EQ(later.links[0].from, "02:00:00:00:00:02");
  EXPECT_EQ(later.links[0].weight, 4'194'303U);  // the way back is no longer known
  const auto last = graph.snapshot(2000 * kMilli);
  EXPECT_TRUE(last.links.empty());
  EXPECT_FALSE(last.problem.empty());
}

TEST(AwdsGraph, ANodeThatHasStartedAgainIsBelievedOnceItsPastHasExpired) {
  Graph graph(AwdsMetric::hops);
  graph.take(topology(1, 9000, 1000, {}), 0);
  EXPECT_FALSE(graph.take(topology(1, 1, 1000, {}), 999 * kMilli));
  EXPECT_TRUE(graph.take(topology(1, 1, 1000, {}), 1000 * kMilli));
}

TEST(AwdsGraph, TheWrongMetricIsReported) {
  Graph graph(AwdsMetric::etx);
  graph.take(topology(1, 1, 3600, {{id(2), 10}}), 0);  // 10: what a hop count sends
  const auto snapshot = graph.snapshot(1);
  EXPECT_TRUE(snapshot.links.empty());
  EXPECT_NE(snapshot.problem.find("metric"), std::string::npos);
}

TEST(AwdsGraph, InventedNodesDoNotFillTheMemory) {
  Graph graph(AwdsMetric::hops);
  Topology invented = topology(0, 1, 60'000, {});
  for (std::size_t i = 0; i < kMaxNodes; ++i) {
    invented.source[3] = static_cast<std::uint8_t>(i >> 8U);
    invented.source[4] = static_cast<std::uint8_t>(i);
    EXPECT_TRUE(graph.take(invented, 0));
  }
  invented.source[5] = 1;
  EXPECT_FALSE(graph.take(invented, 0));
  EXPECT_TRUE(graph.take(invented, 60'000 * kMilli));
}

}  // namespace
}  // namespace mlcca::net::awds
