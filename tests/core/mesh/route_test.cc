// SPDX-License-Identifier: BSD-2-Clause
// Which way packets take.
#include "core/mesh/route.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/core/mesh/meshes.hpp"

namespace mlcca::core::mesh {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)
using Nodes = std::vector<std::uint32_t>;

/// The nodes on the way, both ends included; empty: no way.
Nodes way(const Graph& graph, std::uint32_t from, std::uint32_t to) {
  const auto links = path(graph, bare_mesh(), from, to);
  if (links.empty()) return {};
  Nodes nodes{from};
  for (const std::uint32_t link : links) {
    EXPECT_EQ(graph.links[link].from, nodes.back());
    nodes.push_back(graph.links[link].to);
  }
  return nodes;
}

/// 0 > 3 directly and slowly, or by 1 or by 2.
Graph diamond() {
  Graph graph;
  graph.nodes = 4;
  graph.links = {link(0, 1, 24 * kMega), link(0, 2, 11 * kMega), link(0, 3, kMega),
                 link(1, 3, 24 * kMega), link(2, 3, 24 * kMega)};
  return graph;
}

TEST(RouteTest, TakesTheLeastTime) {
  EXPECT_EQ(way(diamond(), 0, 3), (Nodes{0, 1, 3}));
  EXPECT_EQ(way(diamond(), 0, 1), (Nodes{0, 1}));
}

TEST(RouteTest, LinksHaveADirection) {
  EXPECT_EQ(way(diamond(), 3, 0), Nodes{});
  EXPECT_EQ(way(diamond(), 0, 0), Nodes{});
  EXPECT_EQ(way(diamond(), 0, 9), Nodes{}) << "no such node";
}

TEST(RouteTest, WeightsCountWhereEveryLinkHasOne) {
  Graph graph = diamond();
  for (Link& l : graph.links) l.weight = l.to == 2 ? 1 : 2;
  graph.links[2].weight = 100;
  EXPECT_EQ(way(graph, 0, 3), (Nodes{0, 2, 3}));
  graph.links[3].weight.reset();
  EXPECT_EQ(way(graph, 0, 3), (Nodes{0, 1, 3})) << "least time";
}

TEST(RouteTest, OfEqualSumsTheFewestLinks) {
  Graph graph = diamond();
  for (Link& l : graph.links) l.weight = 1;
  graph.links[2].weight = 2;
  EXPECT_EQ(way(graph, 0, 3), (Nodes{0, 3}));
}

TEST(RouteTest, WeightsThatLeadOverAnUnusableLinkLeadNowhere) {
  Graph graph = diamond();
  for (Link& l : graph.links) l.weight = 10;
  graph.links.erase(graph.links.begin() + 1);
  graph.unusable.push_back({0, 2, std::nullopt});
  EXPECT_EQ(way(graph, 0, 3), (Nodes{0, 3})) << "without a weight it attracts nothing";
  graph.unusable.back().weight = 1;
  for (Link& l : graph.links)
    if (l.from == 2) l.weight = 1;
  EXPECT_EQ(way(graph, 0, 3), Nodes{});
  EXPECT_EQ(way(graph, 0, 1), (Nodes{0, 1})) << "other ways are not touched";
}

TEST(RouteTest, NextHopsAreFollowed) {
  Graph graph = diamond();
  graph.next_hops = {{0, 3, 2}, {2, 3, 3}};
  EXPECT_EQ(way(graph, 0, 3), (Nodes{0, 2, 3}));
}

TEST(RouteTest, NextHopsAreFollowedAsFarAsTheyAreKnown) {
  Graph graph = diamond();
  graph.next_hops = {{0, 3, 2}};
  EXPECT_EQ(way(graph, 0, 3), (Nodes{0, 2, 3}));
}

TEST(RouteTest, NextHopsWithoutALinkLeadNowhere) {
  Graph graph = diamond();
  graph.next_hops = {{0, 3, 2}};
  std::erase_if(graph.links, [](const Link& l) { return l.from == 0 && l.to == 2; });
  EXPECT_EQ(way(graph, 0, 3), Nodes{});
}

TEST(RouteTest, NextHopsThatTurnInACircleLeadNowhere) {
  Graph graph = diamond();
  graph.links = {link(0, 1, kMega), link(0, 3, kMega), link(1, 0, kMega), link(1, 3, kMega)};
  graph.next_hops = {{0, 3, 1}, {1, 3, 0}};
  EXPECT_EQ(way(graph, 0, 3), Nodes{});
  graph.next_hops = {{0, 3, 1}};
  graph.links[3].quality.rate = 1;
  EXPECT_EQ(way(graph, 0, 3), Nodes{}) << "what is reckoned would go back";
}

TEST(RouteTest, ReachesKMaxPathLinksAndNotOneMore) {
  const Graph graph = chain(std::vector<Value>(kMaxPath + 1, kMega));
  EXPECT_EQ(way(graph, 0, kMaxPath).size(), kMaxPath + 1);
  EXPECT_EQ(way(graph, 0, kMaxPath + 1), Nodes{});
  Graph decided = graph;
  for (std::uint32_t i = 0; i <= kMaxPath; ++i)
    decided.next_hops.push_back({i, kMaxPath + 1, i + 1});
  EXPECT_EQ(way(decided, 1, kMaxPath + 1).size(), kMaxPath + 1);
  EXPECT_EQ(way(decided, 0, kMaxPath + 1), Nodes{});
}

TEST(RouteTest, CertainLossIsNoWay) {
  Graph graph = chain({kMega});
  graph.links[0].quality.loss = kCertainLoss;
  EXPECT_EQ(way(graph, 0, 1), Nodes{});
}

/// Least sums between all pairs, by Floyd and Warshall.
std::vector<std::vector<Value>> all_sums(const Graph& graph, const Mesh& mesh) {
  std::vector sums(graph.nodes, std::vector<Value>(graph.nodes, kUnbounded));
  for (std::size_t i = 0; i < graph.nodes; ++i) sums[i][i] = 0;
  for (const Link& l : graph.links)
    sums[l.from][l.to] = packet_time(l.quality, mesh, mesh.packet_bytes);
  for (std::size_t k = 0; k < graph.nodes; ++k)
    for (std::size_t i = 0; i < graph.nodes; ++i)
      for (std::size_t j = 0; j < graph.nodes; ++j)
        if (sums[i][k] != kUnbounded && sums[k][j] != kUnbounded)
          sums[i][j] = std::min(sums[i][j], sums[i][k] + sums[k][j]);
  return sums;
}

TEST(RouteTest, IsTheLeastOfAllWays) {
  RandomMesh random(3);
  for (int round = 0; round < 200; ++round) {
    const Graph graph = random.graph(2 + static_cast<std::uint32_t>(random.below(15)), 40);
    const Mesh mesh = random.mesh(graph);
    const auto sums = all_sums(graph, mesh);
    Paths paths(graph, mesh);
    for (std::uint32_t from = 0; from < graph.nodes; ++from)
      for (std::uint32_t to = 0; to < graph.nodes; ++to) {
        const auto& links = paths.between(from, to);
        ASSERT_EQ(links.empty(), from == to || sums[from][to] == kUnbounded);
        if (links.empty()) continue;
        Value sum = 0;
        for (const std::uint32_t link : links)
          sum += packet_time(graph.links[link].quality, mesh, mesh.packet_bytes);
        ASSERT_EQ(sum, sums[from][to]) << from << " > " << to << " in round " << round;
        ASSERT_EQ(graph.links[links.front()].from, from);
        ASSERT_EQ(graph.links[links.back()].to, to);
      }
  }
}

}  // namespace
}  // namespace mlcca::core::mesh
