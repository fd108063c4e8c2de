// SPDX-License-Identifier: BSD-2-Clause
// Who is asked whether a link is there, and what becomes of a link that is not.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/core/mesh/link_tables.hpp"

namespace mlcca::core::mesh {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

/// Rates from a file (source 1), and whether links are there from another kind of source (0); the
/// third is another one of that kind. This machine is node a.
class PresenceTest : public ::testing::Test {
 protected:
  static Mesh mesh_with(SourceKind kind, SourceKind other) {
    Mesh mesh = mesh_of_three();
    mesh.sources[0].kind = kind;
    mesh.sources[1].kind = SourceKind::file;
    mesh.sources[2].kind = other;
    return mesh;
  }
  void use(SourceKind kind, SourceKind other = SourceKind::file) {
    table = LinkTable(mesh_with(kind, other), 0);
  }
  void say(std::size_t source, std::vector<Sample> links, std::uint64_t now) {
    table.take(source, {.links = std::move(links), .next_hops = {}, .problem = {}}, now);
  }
  void state_rates(std::uint64_t now = 0) {
    say(1,
        {sample(24 * kMega, now), sample(24 * kMega, now, kB, kA),
         sample(11 * kMega, now, kB, "c")},
        now);
  }
  [[nodiscard]] bool carries(std::uint32_t from, std::uint32_t to) const {
    return table.graph().find(from, to) != nullptr;
  }
  [[nodiscard]] Lack lack(std::uint32_t from, std::uint32_t to) const {
    for (const UnusableLink& link : table.graph().unusable)
      if (link.from == from && link.to == to) return link.lack;
    ADD_FAILURE() << "the link is not among those that carry nothing";
    return {};
  }

  LinkTable table{mesh_with(SourceKind::awds, SourceKind::file), 0};
};

TEST_F(PresenceTest, WhatTheProtocolHasLostCarriesNothingWhoeverGivesItARate) {
  state_rates();
  EXPECT_FALSE(carries(0, 1)) << "no source has seen it yet";
  EXPECT_EQ(lack(0, 1), Lack::absent);
  say(0, {sample(0, 1), sample(0, 1, kB, "c")}, 1);
  EXPECT_TRUE(carries(0, 1));
  EXPECT_TRUE(carries(1, 2)) << "links of others, too";
  EXPECT_FALSE(carries(1, 0)) << "the other direction was not seen";
  say(0, {sample(0, 2)}, 2);
  EXPECT_FALSE(carries(1, 2)) << "at once";
  EXPECT_TRUE(carries(0, 1));
}

TEST_F(PresenceTest, WhatComesBackMustLast) {
  state_rates();
  say(0, {sample(0, 1)}, 1);
  say(0, {}, 2);
  for (std::uint64_t now = kSecond; now < kSecond + kHold; now += kSecond) {
    state_rates(now);
    say(0, {sample(0, now)}, now);
    EXPECT_FALSE(carries(0, 1));
    EXPECT_EQ(lack(0, 1), Lack::time);
  }
  state_rates(kSecond + kHold);
  say(0, {sample(0, kSecond + kHold)}, kSecond + kHold);
  EXPECT_TRUE(carries(0, 1));
}

TEST_F(PresenceTest, AProtocolThatIsSilentOrHasAProblemSaysNothing) {
  state_rates();
  Sample seen = sample(0, 1);
  seen.loss = 0;
  say(0, {seen}, 1);
  ASSERT_TRUE(carries(0, 1));
  table.take(0, {.links = {}, .next_hops = {}, .problem = "has closed"}, 1);
  EXPECT_FALSE(carries(0, 1))
      << "what it said of the loss counts on, and that the link is there does not";
  use(SourceKind::awds);
  state_rates();
  say(0, {seen}, 1);
  for (std::uint64_t now = kSecond; now <= 20 * kSecond; now += kSecond) {
    state_rates(now);
    table.expire(now);
    EXPECT_EQ(carries(0, 1), now <= kStale) << now;
  }
}

TEST_F(PresenceTest, WhoKnowsTheLinksOfThisMachineOnlyIsNotAskedOfOthers) {
  for (const SourceKind kind : {SourceKind::babel, SourceKind::olsr, SourceKind::nl80211,
                                SourceKind::wire, SourceKind::batman}) {
    use(kind);
    state_rates();
    EXPECT_TRUE(carries(1, 2));
    EXPECT_FALSE(carries(0, 1));
    EXPECT_FALSE(carries(1, 0));
    say(0, {sample(0, 1), sample(0, 1, kB, kA)}, 1);
    EXPECT_TRUE(carries(0, 1));
  }
}

TEST_F(PresenceTest, AGatewayThatIsNoNodeHasNoLinksOfItsOwn) {
  table = LinkTable(mesh_with(SourceKind::nl80211, SourceKind::file));
  state_rates();
  EXPECT_TRUE(carries(0, 1));
}

TEST_F(PresenceTest, OfSeveralInterfacesOneMustSeeTheLink) {
  use(SourceKind::nl80211, SourceKind::wire);
  state_rates();
  say(0, {}, 1);
  say(2, {sample(0, 1)}, 1);
  EXPECT_TRUE(carries(0, 1));
}

TEST_F(PresenceTest, TheProtocolIsAskedBeforeTheInterface) {
  use(SourceKind::nl80211, SourceKind::awds);
  say(0, {sample(24 * kMega, 0)}, 0);
  EXPECT_FALSE(carries(0, 1)) << "the radio remembers whom the protocol has lost";
  say(2, {sample(0, 1)}, 1);
  EXPECT_TRUE(carries(0, 1));
}

TEST_F(PresenceTest, RatesAloneComeFromTheFile) {
  use(SourceKind::description);
  state_rates();
  EXPECT_TRUE(carries(0, 1));
}

TEST_F(PresenceTest, ALinkThatIsThereWithoutARateLacksThat) {
  say(0, {sample(0, 0)}, 0);
  EXPECT_EQ(lack(0, 1), Lack::rate);
  EXPECT_EQ(table.links()[0].lack, Lack::rate);
  using Lacking = std::vector<std::optional<Lack>>;
  EXPECT_EQ(lacking_from(table.graph(), 0), (Lacking{std::nullopt, Lack::rate, std::nullopt}));
}

/// 0 to 1 lacks a rate and 1 to 2 time; the direct link from 0 to 2 is absent. Node 3 is lost, and
/// 4 is reached.
TEST(LackTest, TheLeastThatIsLackingOnAnyWayIsNamed) {
  Graph graph;
  graph.nodes = 5;
  graph.unusable = {{0, 1, std::nullopt, Lack::rate},
                    {0, 2, std::nullopt, Lack::absent},
                    {1, 2, std::nullopt, Lack::time},
                    {2, 3, std::nullopt, Lack::gone}};
  Link link;
  link.to = 4;
  graph.links.push_back(link);
  using Lacking = std::vector<std::optional<Lack>>;
  EXPECT_EQ(lacking_from(graph, 0),
            (Lacking{std::nullopt, Lack::rate, Lack::time, std::nullopt, std::nullopt}));
  EXPECT_EQ(lacking_from(graph, 1),
            (Lacking{std::nullopt, std::nullopt, Lack::time, std::nullopt, std::nullopt}));
  EXPECT_EQ(lacking_from(graph, 9), Lacking(5)) << "there is no such node";
}

}  // namespace
}  // namespace mlcca::core::mesh
