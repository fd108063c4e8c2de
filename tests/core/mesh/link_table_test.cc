// SPDX-License-Identifier: BSD-2-Clause
// What sources say and what becomes of it as time goes on.
#include "core/mesh/link_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/core/mesh/link_tables.hpp"

namespace mlcca::core::mesh {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

class LinkTableTest : public ::testing::Test {
 protected:
  /// Source 0 sees a link from a to b.
  bool see(Value rate, std::uint64_t now) { return see(sample(rate, now), now); }
  bool see(const Sample& s, std::uint64_t now, std::size_t source = 0) {
    return table.take(source, {.links = {s}, .next_hops = {}, .problem = {}}, now);
  }
  bool see_nothing(std::uint64_t now) { return table.take(0, {}, now); }
  /// bit/s of the link from a to b; 0: it carries nothing.
  [[nodiscard]] Value rate() const {
    const Link* found = table.graph().find(0, 1);
    return found == nullptr ? 0 : found->quality.rate;
  }
  [[nodiscard]] const LinkQuality& quality() const { return table.graph().find(0, 1)->quality; }

  Mesh mesh = mesh_of_three();
  LinkTable table{mesh};
};

TEST_F(LinkTableTest, KnowsTheDescribedNodesAndAddsOthers) {
  EXPECT_EQ(table.graph().nodes, 3U);
  EXPECT_EQ(table.node(kB), 1U);
  EXPECT_EQ(table.node("c"), 2U) << "no address: by its name";
  EXPECT_EQ(table.node("02:00:00:00:00:09"), std::nullopt);
  EXPECT_TRUE(see(sample(kMega, 0, kA, "02:00:00:00:00:09"), 0));
  EXPECT_EQ(table.node("02:00:00:00:00:09"), 3U);
  EXPECT_EQ(table.address(3), "02:00:00:00:00:09");
  EXPECT_EQ(table.graph().nodes, 4U);
}

TEST_F(LinkTableTest, AnUnknownLinkCountsAtOnce) {
  EXPECT_TRUE(see(24 * kMega, kSecond));
  EXPECT_EQ(rate(), 24 * kMega);
  EXPECT_FALSE(see(24 * kMega, 2 * kSecond)) << "younger is no change";
}

TEST_F(LinkTableTest, WorseCountsAtOnce) {
  see(24 * kMega, 0);
  EXPECT_TRUE(see(24 * kMega - 1, kSecond));
  EXPECT_EQ(rate(), 24 * kMega - 1);
}

TEST_F(LinkTableTest, BetterCountsOnceItHasLasted) {
  see(11 * kMega, 0);
  for (std::uint64_t now = kSecond; now < kSecond + kHold; now += kSecond) {
    EXPECT_FALSE(see(24 * kMega, now));
    EXPECT_EQ(table.next_deadline(), std::min(kSecond + kHold, now + kStale + 1));
  }
  EXPECT_FALSE(table.expire(kSecond + kHold - 1));
  EXPECT_EQ(rate(), 11 * kMega);
  EXPECT_TRUE(table.expire(kSecond + kHold));
  EXPECT_EQ(rate(), 24 * kMega);
}

TEST_F(LinkTableTest, BetterCountsAsTheWorstOfItsTime) {
  see(11 * kMega, 0);
  for (int i = 1; i <= 6; ++i)
    see(i == 3 ? 20 * kMega : 24 * kMega, static_cast<std::uint64_t>(i) * kSecond);
  EXPECT_EQ(rate(), 20 * kMega);
}

TEST_F(LinkTableTest, AnInterruptedRiseStartsAgain) {
  see(11 * kMega, 0);
  for (int i = 1; i <= 7; ++i)
    see(i == 3 ? 11 * kMega : 24 * kMega, static_cast<std::uint64_t>(i) * kSecond);
  EXPECT_EQ(rate(), 11 * kMega);
  see(24 * kMega, 8 * kSecond);
  EXPECT_EQ(rate(), 11 * kMega) << "since 4 s";
  see(24 * kMega, 9 * kSecond);
  EXPECT_EQ(rate(), 24 * kMega);
}

TEST_F(LinkTableTest, SmallImprovementsTakeLonger) {
  see(10 * kMega, 0);
  for (std::uint64_t i = 1; i <= 20; ++i) see(11 * kMega, i * kSecond);
  EXPECT_EQ(rate(), 10 * kMega) << "a tenth is not more than the tolerance";
  for (std::uint64_t i = 21; i <= 26; ++i) see(11 * kMega + 1, i * kSecond);
  EXPECT_EQ(rate(), 11 * kMega + 1);
}

TEST_F(LinkTableTest, SmallImprovementsThatLastCountInTheEnd) {
  see(10 * kMega, 0);
  for (std::uint64_t i = 1; i <= 50; ++i) see(11 * kMega - (i == 7 ? 1 : 0), i * kSecond);
  EXPECT_EQ(rate(), 10 * kMega) << "ten times as long as a clear one, and that is not over";
  see(11 * kMega, 51 * kSecond);
  EXPECT_EQ(rate(), 11 * kMega - 1) << "the worst of that time";
}

TEST_F(LinkTableTest, LossAndBusyAreHeldTheOtherWayRound) {
  Sample s = sample(24 * kMega, 0);
  const auto see_with = [&](Value loss, std::uint32_t busy, std::uint64_t now) {
    s.loss = loss;
    s.busy = busy;
    s.taken = now;
    return see(s, now);
  };
  see_with(100'000'000, 200'000, 0);
  EXPECT_TRUE(see_with(300'000'000, 400'000, kSecond));
  EXPECT_EQ(quality().loss, 300'000'000U);
  EXPECT_EQ(table.graph().links[0].busy, 400'000U);
  EXPECT_FALSE(see_with(0, 100'000, 2 * kSecond));
  EXPECT_TRUE(quality().loss_known);
  for (std::uint64_t i = 3; i <= 7; ++i) see_with(0, 100'000, i * kSecond);
  EXPECT_EQ(quality().loss, 0U);
  EXPECT_TRUE(quality().loss_known);
  EXPECT_EQ(table.graph().links[0].busy, 100'000U);
}

TEST_F(LinkTableTest, ALinkThatIsGoneIsUnusableForAWhile) {
  see(24 * kMega, 0);
  EXPECT_TRUE(see_nothing(kSecond));
  EXPECT_EQ(rate(), 0U);
  ASSERT_EQ(table.graph().unusable.size(), 1U);
  EXPECT_EQ(table.next_deadline(), kSecond + kHold);
  EXPECT_TRUE(table.expire(kSecond + kHold));
  EXPECT_TRUE(table.graph().unusable.empty());
  EXPECT_EQ(table.next_deadline(), kUnbounded);
}

TEST_F(LinkTableTest, ALinkThatFlapsMustLast) {
  see(24 * kMega, 0);
  see_nothing(kSecond);
  EXPECT_EQ(table.graph().unusable.at(0).lack, Lack::gone);
  see(24 * kMega, 2 * kSecond);
  EXPECT_EQ(table.graph().unusable.at(0).lack, Lack::time);
  EXPECT_EQ(rate(), 0U);
  see_nothing(3 * kSecond);
  for (std::uint64_t i = 4; i <= 8; ++i) {
    EXPECT_EQ(see(24 * kMega, i * kSecond), i == 4) << i;
    EXPECT_EQ(rate(), 0U) << i;
  }
  EXPECT_TRUE(see(24 * kMega, 9 * kSecond));
  EXPECT_EQ(rate(), 24 * kMega);
}

TEST_F(LinkTableTest, ALinkThatWasGoneForLongIsUnknownAgain) {
  see(24 * kMega, 0);
  see_nothing(kSecond);
  EXPECT_TRUE(see(11 * kMega, kSecond + kHold));
  EXPECT_EQ(rate(), 11 * kMega);
}

TEST_F(LinkTableTest, AnUnknownRateGrantsNothing) {
  see(24 * kMega, 0);
  EXPECT_TRUE(see(0, kSecond));
  EXPECT_EQ(rate(), 0U);
}

TEST_F(LinkTableTest, ASilentSourceGrowsStale) {
  see(24 * kMega, kSecond);
  EXPECT_EQ(table.next_deadline(), kSecond + kStale + 1);
  EXPECT_FALSE(table.expire(kSecond + kStale));
  EXPECT_TRUE(table.expire(kSecond + kStale + 1));
  EXPECT_EQ(rate(), 0U);
  EXPECT_TRUE(table.links()[0].stale);
  EXPECT_EQ(table.links()[0].believed_rate, 0U);
  EXPECT_EQ(table.links()[0].sample.rate, 24 * kMega);
}

TEST_F(LinkTableTest, TheProtocolsOwnValidityMayBeShorter) {
  Sample s = sample(kMega, 0);
  s.valid = kSecond;
  see(s, 0);
  EXPECT_EQ(table.next_deadline(), kSecond + 1);
  s.valid = 100 * kSecond;
  see(s, 1);
  EXPECT_EQ(table.next_deadline(), kStale + 1) << "but not longer";
}

TEST_F(LinkTableTest, ASampleFromTheFutureIsAsOldAsItsArrival) {
  see(sample(kMega, 100 * kSecond), kSecond);
  EXPECT_EQ(table.next_deadline(), kSecond + kStale + 1);
}

TEST_F(LinkTableTest, TheDescriptionNeverAgesAndYieldsToOthers) {
  EXPECT_TRUE(see(sample(24 * kMega, 0), 0, 2));
  EXPECT_EQ(table.next_deadline(), kUnbounded);
  table.expire(1000 * kSecond);
  EXPECT_EQ(rate(), 24 * kMega);
  EXPECT_TRUE(see(sample(6 * kMega, 1000 * kSecond), 1000 * kSecond));
  EXPECT_EQ(rate(), 6 * kMega);
}

TEST_F(LinkTableTest, EffectiveBeatsDerivedBeatsPhy) {
  Sample phy = sample(54 * kMega, 0);
  Sample derived = sample(30 * kMega, 0);
  derived.kind = RateKind::derived;
  Sample effective = sample(20 * kMega, 0);
  effective.kind = RateKind::effective;
  see(phy, 0, 0);
  see(derived, 0, 1);
  EXPECT_EQ(quality(), (LinkQuality{.rate = 30 * kMega, .kind = RateKind::derived}));
  see(effective, 0, 0);
  EXPECT_EQ(quality(), (LinkQuality{.rate = 20 * kMega, .kind = RateKind::effective}));
}

TEST_F(LinkTableTest, OfEqualKindsTheYoungestCounts) {
  see(sample(11 * kMega, 2), 2, 1);
  see(sample(10 * kMega, 1), 3, 0);
  EXPECT_EQ(rate(), 11 * kMega);
  see(sample(10 * kMega, 4), 4, 0);
  EXPECT_EQ(rate(), 10 * kMega);
}

TEST_F(LinkTableTest, KindsAreComparedByWhatTheyCarry) {
  mesh.packet_bytes = 1000;
  mesh.packet_time = 500'000;  // PHY 16 Mbit/s: 0.5 + 0.5 ms for 8000 bits, 8 Mbit/s
  LinkTable fresh(mesh);
  table = fresh;
  Sample effective = sample(9 * kMega, 0);
  effective.kind = RateKind::effective;
  see(effective, 0);
  EXPECT_TRUE(see(16 * kMega, kSecond)) << "more bits, but they carry less";
  EXPECT_EQ(quality().kind, RateKind::phy);
  effective.taken = 2 * kSecond;
  EXPECT_FALSE(see(effective, 2 * kSecond)) << "9 is better than 8";
  EXPECT_EQ(quality().kind, RateKind::phy);
}

TEST_F(LinkTableTest, ASourceWithoutRatesRefinesLossAndWeight) {
  see(24 * kMega, 0);
  Sample etx = sample(0, 0);
  etx.loss = 250'000'000;
  etx.weight = 341;
  EXPECT_TRUE(see(etx, 0, 1));
  EXPECT_EQ(rate(), 24 * kMega);
  EXPECT_EQ(quality().loss, 250'000'000U);
  EXPECT_EQ(table.graph().links[0].weight, 341U);
}

TEST_F(LinkTableTest, ASourceWithoutRatesAloneMakesNoLink) {
  Sample etx = sample(0, 0);
  etx.weight = 256;
  EXPECT_TRUE(see(etx, 0, 1));
  EXPECT_TRUE(table.graph().links.empty());
  EXPECT_EQ(table.graph().unusable, (std::vector<UnusableLink>{{0, 1, 256, Lack::rate}}));
}

TEST_F(LinkTableTest, TheWorstLossOfAllSourcesCounts) {
  Sample first = sample(24 * kMega, 0);
  first.loss = 300'000'000;
  Sample second = sample(0, 0);
  second.loss = 100'000'000;
  see(first, 0, 0);
  see(second, 0, 1);
  EXPECT_EQ(quality().loss, 300'000'000U);
}

TEST_F(LinkTableTest, WeightsAreAllOfOneSource) {
  Sample s = sample(kMega, 0);
  s.weight = 1;
  see(s, 0, 1);
  EXPECT_EQ(table.graph().links[0].weight, 1U);
  Sample other = sample(kMega, 0, kB, kA);
  other.weight = 1000;
  see(other, 0, 0);
  EXPECT_EQ(table.graph().find(0, 1)->weight, std::nullopt) << "source 0 does not weigh it";
  EXPECT_EQ(table.graph().find(1, 0)->weight, 1000U);
}

TEST_F(LinkTableTest, NextHopsAreThoseOfTheFirstSourceThatKnows) {
  const Snapshot first{.links = {}, .next_hops = {{kA, "c", kB}}, .problem = {}};
  const Snapshot second{.links = {}, .next_hops = {{kA, "c", "c"}, {kB, "c", "c"}}, .problem = {}};
  EXPECT_TRUE(table.take(1, second, 0));
  EXPECT_TRUE(table.take(0, first, kSecond));
  EXPECT_EQ(table.graph().next_hops, (std::vector<NextHopIndex>{{0, 2, 1}, {1, 2, 2}}));
  EXPECT_EQ(table.next_deadline(), kStale + 1);
  EXPECT_TRUE(table.expire(kStale + 1)) << "source 1 has not reported";
  EXPECT_EQ(table.graph().next_hops, (std::vector<NextHopIndex>{{0, 2, 1}}));
}

TEST_F(LinkTableTest, NextHopsThatAreNotReportedAgainAreGone) {
  table.take(0, {.links = {}, .next_hops = {{kA, "c", kB}}, .problem = {}}, 0);
  ASSERT_EQ(table.graph().next_hops.size(), 1U);
  EXPECT_TRUE(table.take(0, {}, kSecond));
  EXPECT_TRUE(table.graph().next_hops.empty());
}

TEST_F(LinkTableTest, AProblemIsKeptUntilItIsOver) {
  see(24 * kMega, 0);
  EXPECT_TRUE(table.take(0, {.links = {}, .next_hops = {}, .problem = "no such interface"}, 1));
  EXPECT_EQ(table.problem(0), "no such interface");
  EXPECT_EQ(rate(), 0U);
  EXPECT_EQ(table.problem(1), "");
  EXPECT_EQ(table.problem(7), "");
  see(24 * kMega, 2);
  EXPECT_EQ(table.problem(0), "");
}

TEST_F(LinkTableTest, OfASourceWithAProblemOnlyWhatItWarnedOfCounts) {
  Sample s = sample(24 * kMega, kSecond);
  s.loss = 300'000'000;
  s.weight = 7;
  see(s, kSecond);
  EXPECT_EQ(table.graph().links.at(0).weight, 7U);
  EXPECT_TRUE(table.take(0, {.links = {}, .next_hops = {}, .problem = "has closed"}, kSecond));
  ASSERT_EQ(table.graph().unusable.size(), 1U);
  EXPECT_EQ(table.graph().unusable[0].weight, std::nullopt) << "at the same moment, too";
  ASSERT_EQ(table.links().size(), 1U);
  EXPECT_EQ(table.links()[0].sample.rate, 0U);
  EXPECT_EQ(table.links()[0].sample.weight, std::nullopt);
  EXPECT_EQ(table.links()[0].sample.loss, 300'000'000U);
}

TEST_F(LinkTableTest, ASourceThatIsSilencedMakesNoLinkBetter) {
  Sample etx = sample(0, kSecond);
  etx.loss = 250'000'000;
  see(sample(24 * kMega, kSecond), kSecond);
  see(etx, kSecond, 1);
  ASSERT_EQ(quality().loss, 250'000'000U);
  for (std::uint64_t now = 2 * kSecond; now < 20 * kSecond; now += kSecond) {
    table.take(1, {.links = {}, .next_hops = {}, .problem = "has closed"}, now);
    see(sample(24 * kMega, now), now);
    EXPECT_EQ(rate(), 24 * kMega);
    EXPECT_EQ(quality().loss, 250'000'000U);
  }
  for (std::uint64_t now = 20 * kSecond; now < 30 * kSecond; now += kSecond) {
    table.take(1, {}, now);  // it reports again, without this link
    see(sample(24 * kMega, now), now);
  }
  EXPECT_EQ(quality().loss, 0U);
}

TEST_F(LinkTableTest, ALossThatGrewStaleCountsOn) {
  Sample etx = sample(0, 0);
  etx.loss = 250'000'000;
  see(etx, 0, 1);
  for (std::uint64_t now = 0; now < 20 * kSecond; now += kSecond) see(sample(kMega, now), now);
  EXPECT_EQ(quality().loss, 250'000'000U);
}

TEST_F(LinkTableTest, ChannelsAreThoseOfTheRatesSource) {
  Sample rated = sample(24 * kMega, 0);
  Sample other = sample(0, 0);
  other.channel = 5;
  see(rated, 0, 0);
  EXPECT_EQ(table.graph().links[0].channel, kAnyChannel);
  see(other, 0, 1);
  EXPECT_EQ(table.graph().links[0].channel, 5U);
  rated.channel = 2412;
  see(rated, 0, 0);
  EXPECT_EQ(table.graph().links[0].channel, 2412U);
}

TEST_F(LinkTableTest, OfTwoReportsInOneSnapshotTheSlowerCounts) {
  const Snapshot twice{
      .links = {sample(6 * kMega, 0), sample(24 * kMega, 0)}, .next_hops = {}, .problem = {}};
  table.take(0, twice, 0);
  EXPECT_EQ(rate(), 6 * kMega);
}

TEST_F(LinkTableTest, ALinkToItselfIsNone) {
  see(sample(kMega, 0, kA, kA), 0);
  EXPECT_TRUE(table.graph().links.empty());
}

TEST_F(LinkTableTest, MoreNodesThanThereIsRoomForAreIgnoredAndSaid) {
  Snapshot crowd;
  const auto name = [](std::size_t i) { return "node-" + std::to_string(i); };
  for (std::size_t i = 3; i < kMaxNodes + 1; ++i)
    crowd.links.push_back(sample(kMega, 0, kA, name(i).c_str()));
  table.take(0, crowd, 0);
  EXPECT_EQ(table.graph().nodes, kMaxNodes);
  EXPECT_EQ(table.graph().links.size(), kMaxNodes - 3);
  EXPECT_NE(table.problem(0).find("links or next hops are ignored"), std::string::npos);
}

TEST_F(LinkTableTest, MoreLinksThanThereIsRoomForAreIgnoredAndSaid) {
  Snapshot crowd;
  const auto name = [](std::size_t i) { return "node-" + std::to_string(i); };
  for (std::size_t i = 0; i < 100; ++i)
    for (std::size_t j = 0; j < 100; ++j)
      if (i != j) crowd.links.push_back(sample(kMega, 0, name(i).c_str(), name(j).c_str()));
  ASSERT_GT(crowd.links.size(), kMaxLinks);
  table.take(0, crowd, 0);
  EXPECT_EQ(table.graph().links.size(), kMaxLinks);
  EXPECT_NE(table.problem(0).find("ignored"), std::string::npos);
  crowd.links.resize(10);
  table.take(0, crowd, 1);
  EXPECT_EQ(table.problem(0), "");
}

TEST_F(LinkTableTest, LinksOfUndescribedNodesMakeRoomForThoseOfDescribedNodes) {
  Snapshot crowd;
  const auto name = [](std::size_t i) { return "node-" + std::to_string(i); };
  for (std::size_t i = 0; i < 100; ++i)
    for (std::size_t j = 0; j < 100; ++j)
      if (i != j) crowd.links.push_back(sample(kMega, 0, name(i).c_str(), name(j).c_str()));
  table.take(0, crowd, 0);
  ASSERT_EQ(table.graph().links.size(), kMaxLinks);
  Snapshot real;
  real.links.push_back(sample(kMega, 0));
  table.take(1, real, 1);
  EXPECT_EQ(rate(), kMega);
  EXPECT_EQ(table.problem(1), "");
  table.take(0, crowd, 2);
  EXPECT_EQ(rate(), kMega);
  EXPECT_EQ(table.graph().links.size(), kMaxLinks);
}

TEST_F(LinkTableTest, NodesThatNoSourceReportsAnyMoreGiveTheirRoom) {
  Snapshot crowd;
  const auto name = [](std::size_t i) { return "node-" + std::to_string(i); };
  for (std::size_t i = 3; i < kMaxNodes; ++i)
    crowd.links.push_back(sample(kMega, 0, kA, name(i).c_str()));
  table.take(0, crowd, 0);
  ASSERT_EQ(table.graph().nodes, kMaxNodes);
  Snapshot later;
  later.links.push_back(sample(kMega, 10 * kSecond, kA, "newcomer"));
  later.next_hops.push_back({.from = kA, .to = "far", .via = "newcomer"});
  table.take(0, Snapshot{}, 0);
  table.expire(100 * kSecond);
  table.take(0, later, 100 * kSecond);
  EXPECT_EQ(table.problem(0), "");
  ASSERT_TRUE(table.node("newcomer") && table.node("far"));
  EXPECT_EQ(table.address(*table.node("newcomer")), "newcomer");
  EXPECT_LT(table.graph().nodes, 10U);
}

TEST_F(LinkTableTest, DescribedLinksReportThemselves) {
  mesh.links = {{.from = 0, .to = 2, .rate = kMega, .loss = 7, .channel = 3, .origin = {}}};
  EXPECT_TRUE(table.take(2, described_snapshot(mesh, 0), 0));
  ASSERT_EQ(table.graph().links.size(), 1U);
  const Link& link = table.graph().links.front();
  EXPECT_EQ(link.from, 0U);
  EXPECT_EQ(link.to, 2U);
  EXPECT_EQ(link.channel, 3U);
  EXPECT_EQ(link.quality.rate, kMega);
  EXPECT_EQ(link.quality.loss, 7U);
}

/// A rise is to what all samples of the last hold_up have borne out, whatever happens.
TEST_F(LinkTableTest, NeverPromisesWhatHasNotLasted) {
  RandomMesh random(9);
  std::vector<std::pair<std::uint64_t, Value>> seen{{1, 24 * kMega}};
  std::uint64_t now = 1;
  see(24 * kMega, now);
  int rises = 0;
  for (int i = 0; i < 20'000; ++i) {
    now += random.below(kSecond / 2);
    const bool gone = random.below(50) == 0;
    const Value observed = gone ? 0 : (10 + random.below(40)) * kMega;
    const Value before = rate();
    if (gone) {
      see_nothing(now);
    } else {
      see(observed, now);
    }
    seen.emplace_back(now, observed);
    ASSERT_LE(rate(), observed) << "worse counts at once";
    if (rate() <= before) continue;
    ++rises;
    for (auto it = seen.rbegin(); it != seen.rend() && now - it->first < kHold; ++it)
      ASSERT_LE(rate(), it->second) << "after " << i << " samples";
  }
  EXPECT_GT(rises, 100);
}

}  // namespace
}  // namespace mlcca::core::mesh
