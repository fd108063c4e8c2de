// SPDX-License-Identifier: BSD-2-Clause
// Who shares the medium with whom, against a naive reckoning.
#include "core/mesh/domains.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/core/mesh/meshes.hpp"

namespace mlcca::core::mesh {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)
using Links = std::set<std::uint32_t>;

std::string plain(std::uint32_t node) { return std::to_string(node); }

/// The links of each domain.
std::vector<Links> members(const Graph& graph, const Domains& domains) {
  std::vector<Links> result(domains.count());
  for (std::uint32_t link = 0; link < graph.links.size(); ++link)
    for (const std::uint32_t domain : domains.of_link(link)) result[domain].insert(link);
  return result;
}

Mesh with(Interference interference, std::uint32_t hops = 0) {
  Mesh mesh = bare_mesh();
  mesh.interference = interference;
  mesh.hops = hops;
  return mesh;
}

/// Links between nodes, either direction, carrying or not.
std::vector<std::uint32_t> distances(const Graph& graph, std::uint32_t from) {
  std::vector<std::uint32_t> result(graph.nodes, 1'000'000);
  std::deque<std::uint32_t> open{from};
  result[from] = 0;
  const auto reach = [&](std::uint32_t a, std::uint32_t b) {
    if (result[b] <= result[a] + 1) return;
    result[b] = result[a] + 1;
    open.push_back(b);
  };
  for (; !open.empty(); open.pop_front()) {
    const std::uint32_t node = open.front();
    const auto visit = [&](const auto& link) {
      if (link.from == node) reach(node, link.to);
      if (link.to == node) reach(node, link.from);
    };
    for (const Link& l : graph.links) visit(l);
    for (const UnusableLink& l : graph.unusable) visit(l);
  }
  return result;
}

bool same_channel(const Link& a, const Link& b) {
  return a.channel == b.channel || a.channel == kAnyChannel || b.channel == kAnyChannel;
}

Links naive_neighbourhood(const Graph& graph, std::uint32_t link, std::uint32_t hops) {
  const Link& mine = graph.links[link];
  const auto from = distances(graph, mine.from);
  const auto to = distances(graph, mine.to);
  Links result;
  for (std::uint32_t i = 0; i < graph.links.size(); ++i) {
    const Link& other = graph.links[i];
    const auto nearest = std::min({from[other.from], from[other.to], to[other.from], to[other.to]});
    if (nearest <= hops && same_channel(mine, other)) result.insert(i);
  }
  return result;
}

TEST(DomainsTest, SingleDomainHasAllLinks) {
  const Graph graph = chain({kMega, kMega, kMega});
  const Domains domains(graph, with(Interference::single_domain));
  EXPECT_EQ(members(graph, domains), (std::vector<Links>{{0, 1, 2}}));
  EXPECT_EQ(domains.name(0, plain), "all links");
}

TEST(DomainsTest, ChannelsShareNothing) {
  Graph graph = chain({kMega, kMega, kMega});
  graph.links[1].channel = 2412;
  const Domains domains(graph, with(Interference::channel));
  EXPECT_EQ(members(graph, domains), (std::vector<Links>{{0, 2}, {1}}));
  EXPECT_EQ(domains.name(1, plain), "channel 2412");
}

TEST(DomainsTest, ALinkOfUnknownChannelIsOnEveryChannel) {
  Graph graph = chain({kMega, kMega, kMega});
  graph.links[1].channel = 2412;
  graph.links[2].channel = kAnyChannel;
  const Domains domains(graph, with(Interference::channel));
  EXPECT_EQ(members(graph, domains), (std::vector<Links>{{0, 2}, {1, 2}}));
  for (Link& l : graph.links) l.channel = kAnyChannel;
  EXPECT_EQ(members(graph, Domains(graph, with(Interference::channel))),
            (std::vector<Links>{{0, 1, 2}}));
}

TEST(DomainsTest, DescribedSetsTakeBothDirectionsAndTheRestSharesWithAll) {
  Graph graph = chain({kMega, kMega, kMega});
  graph.links.insert(graph.links.begin() + 1, link(1, 0, kMega));
  Mesh mesh = with(Interference::explicit_sets);
  mesh.domains.push_back({.name = "west", .links = {{0, 1}, {1, 2}}, .origin = {}});
  mesh.domains.push_back({.name = "east", .links = {{2, 1}, {3, 2}}, .origin = {}});
  const Domains all(graph, mesh);
  EXPECT_EQ(members(graph, all), (std::vector<Links>{{0, 1, 2}, {2, 3}}));
  EXPECT_EQ(all.name(0, plain), "west");
  mesh.domains.pop_back();
  const Domains some(graph, mesh);
  EXPECT_EQ(members(graph, some), (std::vector<Links>{{0, 1, 2}, {0, 1, 2, 3}}));
  EXPECT_EQ(some.name(1, plain), "all links");
}

TEST(DomainsTest, KHopDomainsAreNeighbourhoodsWithoutRepetition) {
  const Graph graph = chain({kMega, kMega, kMega, kMega, kMega});
  const Domains none(graph, with(Interference::k_hop, 0));
  EXPECT_EQ(members(graph, none),
            (std::vector<Links>{{0, 1}, {0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4}}));
  EXPECT_EQ(none.name(1, plain), "around 1 > 2");
  const Domains one(graph, with(Interference::k_hop, 1));
  EXPECT_EQ(
      members(graph, one),
      (std::vector<Links>{{0, 1, 2}, {0, 1, 2, 3}, {0, 1, 2, 3, 4}, {1, 2, 3, 4}, {2, 3, 4}}));
  const Domains far(graph, with(Interference::k_hop, 16));
  EXPECT_EQ(members(graph, far), (std::vector<Links>{{0, 1, 2, 3, 4}})) << "equal sets are one";
}

TEST(DomainsTest, EndsOfALinkThatCarriesNothingStillShareTheMedium) {
  Graph graph = chain({kMega, kMega, kMega});
  graph.links.erase(graph.links.begin() + 1);
  const Mesh mesh = with(Interference::k_hop, 1);
  EXPECT_EQ(Domains(graph, mesh).count(), 2U);
  graph.unusable.push_back({1, 2, std::nullopt});
  EXPECT_EQ(members(graph, Domains(graph, mesh)), (std::vector<Links>{{0, 1}}));
}

TEST(DomainsTest, KHopAgreesWithTheNaiveReckoning) {
  RandomMesh random(1);
  for (int round = 0; round < 300; ++round) {
    Graph graph = random.graph(2 + static_cast<std::uint32_t>(random.below(30)), random.below(80));
    for (std::uint64_t i = random.below(5); i > 0; --i)
      graph.unusable.push_back({static_cast<std::uint32_t>(random.below(graph.nodes)),
                                static_cast<std::uint32_t>(random.below(graph.nodes)),
                                std::nullopt});
    const auto hops = static_cast<std::uint32_t>(random.below(5));
    const Domains domains(graph, with(Interference::k_hop, hops));
    const auto found = members(graph, domains);
    std::set<Links> expected;
    for (std::uint32_t link = 0; link < graph.links.size(); ++link)
      expected.insert(naive_neighbourhood(graph, link, hops));
    ASSERT_EQ(std::set<Links>(found.begin(), found.end()), expected) << "round " << round;
    ASSERT_EQ(found.size(), expected.size()) << "round " << round;
  }
}

TEST(DomainsTest, EveryLinkIsInADomainWhateverTheInterference) {
  RandomMesh random(2);
  for (int round = 0; round < 300; ++round) {
    const Graph graph = random.graph(12, random.below(40));
    const Domains domains(graph, random.mesh(graph));
    for (std::uint32_t link = 0; link < graph.links.size(); ++link) {
      const auto in = domains.of_link(link);
      ASSERT_FALSE(in.empty());
      ASSERT_TRUE(std::ranges::is_sorted(in));
      ASSERT_EQ(std::ranges::adjacent_find(in), in.end());
    }
  }
}

TEST(DomainsTest, BusyIsTheWorstOfADomain) {
  Graph graph = chain({kMega, kMega, kMega});
  graph.links[0].busy = 100'000;
  graph.links[1].busy = 300'000;
  graph.links[2].channel = 7;
  const Domains domains(graph, with(Interference::channel));
  EXPECT_EQ(domains.busy_of(0), 300'000'000'000U) << "0.3 of 1e12 ps";
  EXPECT_EQ(domains.busy_of(1), 0U);
}

}  // namespace
}  // namespace mlcca::core::mesh
