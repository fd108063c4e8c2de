// SPDX-License-Identifier: BSD-2-Clause
// Medium time against numbers that were worked out by hand or in another arithmetic.
#include "core/mesh/medium_time.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/core/mesh/meshes.hpp"

namespace mlcca::core::mesh {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

__extension__ using Wide = unsigned __int128;

constexpr LinkQuality k24{.rate = 24 * kMega};
constexpr LinkQuality k11{.rate = 11 * kMega};

TEST(PaperRateTest, TwoLinksTakeTurns) {
  // 24 * 11 / (24 + 11) = 264 / 35 Mbit/s
  EXPECT_EQ(paper_rate(std::array{24 * kMega, 11 * kMega}), 264 * kMega / 35);
  EXPECT_EQ(paper_rate(std::array{24 * kMega, 11 * kMega}), 7'542'857U);
  EXPECT_EQ(paper_rate(std::array{24 * kMega}), 24 * kMega);
}

TEST(PaperRateTest, ChainOfFour) {
  // 1/24 + 1/11 + 1/24 + 1/24 = (11 + 24 + 11 + 11) / 264
  EXPECT_EQ(paper_rate(std::array{24 * kMega, 11 * kMega, 24 * kMega, 24 * kMega}),
            264 * kMega / 57);
}

TEST(PaperRateTest, NoRatesAndUnknownOnesGiveNothing) {
  EXPECT_EQ(paper_rate({}), 0U);
  EXPECT_EQ(paper_rate(std::array{24 * kMega, Value{0}}), 0U);
}

TEST(PaperRateTest, ManyEqualLinksAreRoundedDownByLessThanTwo) {
  for (std::size_t links = 1; links <= 32; ++links) {
    const std::vector<Value> rates(links, 11 * kMega);
    const Value exact = 11 * kMega / links;
    EXPECT_LE(paper_rate(rates), exact) << links;
    EXPECT_GE(paper_rate(rates) + (links <= 16 ? 0 : 2), exact) << links;
  }
}

TEST(PacketTimeTest, IsBitsByRate) {
  // 1500 bytes at 24 Mbit/s: 12000 / 24e6 s = 500 us
  EXPECT_EQ(packet_time(k24, bare_mesh(), 1500), 500 * kMega);
  // 1 byte at 11 Mbit/s: 8 / 11 us = 727272.7 ps, rounded up
  EXPECT_EQ(packet_time(k11, bare_mesh(), 1), 727'273U);
}

TEST(PacketTimeTest, OverheadAndHeaderCountForPhyRatesOnly) {
  Mesh mesh = bare_mesh();
  mesh.header_bytes = 36;
  mesh.packet_time = 100'000;  // 100 us
  // 100 us + 8 * 1536 / 24 us = 612 us
  EXPECT_EQ(packet_time(k24, mesh, 1500), 612 * kMega);
  for (const RateKind kind : {RateKind::effective, RateKind::derived})
    EXPECT_EQ(packet_time({.rate = 24 * kMega, .kind = kind}, mesh, 1500), 500 * kMega);
}

TEST(PacketTimeTest, LostPacketsAreSentAgain) {
  // every fifth is lost: 500 / 0.8 us
  EXPECT_EQ(packet_time({.rate = 24 * kMega, .loss = 200'000'000}, bare_mesh(), 1500), 625 * kMega);
}

TEST(PacketTimeTest, UnknownRateAndCertainLossNeverGetThrough) {
  EXPECT_EQ(packet_time({}, bare_mesh(), 1), kUnbounded);
  EXPECT_EQ(packet_time({.rate = kMega, .loss = kCertainLoss}, bare_mesh(), 1), kUnbounded);
  EXPECT_EQ(event_time({}, bare_mesh(), 100'000), kUnbounded);
  EXPECT_EQ(medium_time({}, bare_mesh(), 1, 1), kUnbounded);
}

TEST(PacketTimeTest, SaturatesInsteadOfWrapping) {
  EXPECT_EQ(packet_time({.rate = 1}, bare_mesh(), kUnbounded), kUnbounded);
  Mesh mesh = bare_mesh();
  mesh.packet_time = kUnbounded;
  EXPECT_EQ(packet_time(k24, mesh, 1), kUnbounded);
  EXPECT_EQ(event_time({.rate = 1}, bare_mesh(), kUnbounded), kUnbounded);
}

TEST(EventTimeTest, IsTheSumOfItsPackets) {
  Mesh mesh = bare_mesh();
  mesh.packet_bytes = 1000;
  mesh.packet_time = 50'000;
  const Value full = packet_time(k11, mesh, 1000);
  EXPECT_EQ(event_time(k11, mesh, 0), 50 * kMega) << "an empty packet";
  EXPECT_EQ(event_time(k11, mesh, 1000), full);
  EXPECT_EQ(event_time(k11, mesh, 1001), full + packet_time(k11, mesh, 1));
  EXPECT_EQ(event_time(k11, mesh, 3000), 3 * full);
  EXPECT_EQ(event_time(k11, mesh, 3250), 3 * full + packet_time(k11, mesh, 250));
}

TEST(EventTimeTest, PacketsHoldAtLeastAByte) {
  Mesh mesh = bare_mesh();
  mesh.packet_time = 50'000;
  for (const std::uint32_t bytes : {0, 1}) {
    mesh.packet_bytes = bytes;
    EXPECT_EQ(event_time(k11, mesh, 3), 3 * packet_time(k11, mesh, 1)) << bytes;
    EXPECT_EQ(reckoned_event(mesh, 0), 1U);
  }
}

TEST(MediumTimeTest, DemandOfThePaperTakesItsShareOfASecond) {
  // 3.2 Mbit/s by 24 and 11 Mbit/s: 2/15 + 16/55 = 70/165 = 0.4242 of the time
  const Value demand = 400'000;
  const Value sum =
      medium_time(k24, bare_mesh(), demand, 0) + medium_time(k11, bare_mesh(), demand, 0);
  EXPECT_NEAR(static_cast<double>(sum), 70.0 / 165 * 1e12, 1e4);
  EXPECT_GE(Wide{sum} * 165, Wide{70} * kFullTime) << "rounded up";
}

TEST(MediumTimeTest, SmallEventsTakeMoreThanFullPackets) {
  Mesh mesh = bare_mesh();
  mesh.packet_time = 100'000;
  // 1000 bytes/s as 100 events of 10 bytes: 100 * (100 us + 80/24 us)
  EXPECT_EQ(medium_time(k24, mesh, 1000, 10), 100 * packet_time(k24, mesh, 10));
  EXPECT_GT(medium_time(k24, mesh, 1000, 10), medium_time(k24, mesh, 1000, 0));
  EXPECT_EQ(medium_time(k24, mesh, 1000, 0), medium_time(k24, mesh, 1000, mesh.packet_bytes));
}

// Frame exchange times of IEEE 802.11 (ERP-OFDM 24 Mbit/s; HR/DSSS 11 Mbit/s, long preamble):
// SIFS, DIFS, mean back-off CWmin/2 slots, preamble and SIGNAL, acknowledgement of 14 bytes.
TEST(MediumTimeTest, OverheadOf802Dot11BringsTheRouteTo4Point60) {
  // OFDM at 24: DIFS 34, back-off 15/2 * 9, preamble and SIGNAL 20, SIFS 16, ACK 20 + 2 symbols
  // of 4; SERVICE and tail are 22 bits, so 36 + 1500 bytes are 12310 bits, 129 symbols of 96 bits.
  const double ofdm = 34 + 67.5 + 20 + 129 * 4 + 16 + 28;
  EXPECT_DOUBLE_EQ(ofdm, 681.5);
  // HR/DSSS at 11: DIFS 50, back-off 31/2 * 20, preamble 192, SIFS 10, ACK 192 + 112/2
  const double dsss = 50 + 310 + 192 + 1536 * 8 / 11.0 + 10 + 192 + 56;
  EXPECT_NEAR(dsss, 1927, 0.2);

  // The same as overhead time of a mesh each: what is not bits at the link's rate.
  Mesh at24 = bare_mesh();
  at24.header_bytes = 36;
  at24.packet_time = 169'500;  // 681.5 us - 8 * 1536 / 24 us
  Mesh at11 = at24;
  at11.packet_time = 810'000;
  const Value both = packet_time(k24, at24, 1500) + packet_time(k11, at11, 1500);
  EXPECT_EQ(packet_time(k24, at24, 1500), 681'500'000U);
  const double rate = 12'000.0 / (static_cast<double>(both) * 1e-12);
  EXPECT_NEAR(rate, 4.60e6, 5e3);
  const Value small = packet_time(k24, at24, 200) + packet_time(k11, at11, 200);
  EXPECT_NEAR(1'600.0 / (static_cast<double>(small) * 1e-12), 1.30e6, 5e3);
}

}  // namespace
}  // namespace mlcca::core::mesh
