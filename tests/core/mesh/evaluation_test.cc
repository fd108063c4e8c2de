// SPDX-License-Identifier: BSD-2-Clause
// Both numbers of a route: worked examples, and laws on random networks.
#include "core/mesh/evaluation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "tests/core/mesh/meshes.hpp"

namespace mlcca::core::mesh {
namespace {

using namespace testing;  // NOLINT(google-build-using-namespace)

constexpr Value kVideo = 400'000;  // bytes/s: 3.2 Mbit/s, the paper's video

double mbit(Value bytes_per_second) { return static_cast<double>(bytes_per_second) * 8 / 1e6; }

RouteRate evaluated(const Graph& graph, const Mesh& mesh, const Taken& taken = nothing_taken) {
  return evaluate(graph, mesh, Domains(graph, mesh), whole(graph), 0, taken);
}

Value only_share(const Graph& graph, const Mesh& mesh, Value demand) {
  const auto all = shares(graph, mesh, Domains(graph, mesh), whole(graph), demand, 0);
  EXPECT_EQ(all.size(), 1U);
  return all.front().time;
}

TEST(EvaluationTest, PaperAndWholeMediumAreTheSameNumber) {
  const Graph graph = chain({24 * kMega, 11 * kMega});
  const RouteRate rate = evaluated(graph, bare_mesh());
  // 264/35 Mbit/s = 33/35 MByte/s = 942857.14 bytes/s
  EXPECT_EQ(rate.paper, 33 * kMega / 35);
  EXPECT_NEAR(mbit(rate.available), 7.542857, 1e-4);
  EXPECT_LE(rate.available, rate.paper);
  EXPECT_EQ(rate.links, whole(graph));
}

TEST(EvaluationTest, ReservationsOfThePaperAddUp) {
  const Graph graph = chain({24 * kMega, 11 * kMega});
  const Value video = only_share(graph, bare_mesh(), kVideo);
  EXPECT_NEAR(static_cast<double>(video), 0.4242e12, 1e8);
  EXPECT_NEAR(static_cast<double>(2 * video), 0.8485e12, 1e8);
  EXPECT_NEAR(static_cast<double>(3 * video), 1.2727e12, 1e8);
  EXPECT_LE(2 * video, kFullTime);
  EXPECT_GT(3 * video, kFullTime) << "three pass the paper's test one by one, and do not fit";
  EXPECT_GT(evaluated(graph, bare_mesh()).paper, kVideo);
}

TEST(EvaluationTest, WhatAFlowTakesIsRoundedUp) {
  const Graph graph = chain({11 * kMega});
  const Mesh mesh = bare_mesh();
  // 7 bytes take 56/11 us, 5090910 ps; 3/7 of that are 2181818.57 ps.
  const auto flow = shares(graph, mesh, Domains(graph, mesh), whole(graph), 3, 7);
  EXPECT_EQ(flow, (std::vector<Share>{{.domain = 0, .time = 2'181'819}}));
}

TEST(EvaluationTest, LimitBackgroundAndReservationsLeaveTheRest) {
  const Graph graph = chain({24 * kMega, 11 * kMega});
  Mesh mesh = bare_mesh();
  mesh.limit = 800'000;
  const Value video = only_share(graph, mesh, kVideo);
  EXPECT_NEAR(mbit(evaluated(graph, mesh).available), 6.034, 5e-4);
  const auto after_video = [&](std::size_t) { return video; };
  EXPECT_NEAR(mbit(evaluated(graph, mesh, after_video).available), 2.834, 5e-4);
  const auto and_others = [&](std::size_t) { return video + kFullTime / 10; };
  EXPECT_NEAR(mbit(evaluated(graph, mesh, and_others).available), 2.080, 5e-4);
  EXPECT_NEAR(static_cast<double>(only_share(graph, mesh, 100'000)), 0.106e12, 1e9);
}

TEST(EvaluationTest, ASlowerLinkBreaksWhatThePaperWouldKeep) {
  const Graph graph = chain({6 * kMega, 11 * kMega});
  Mesh mesh = bare_mesh();
  mesh.limit = 800'000;
  const RouteRate rate = evaluated(graph, mesh);
  EXPECT_NEAR(mbit(rate.paper), 3.882, 5e-4);
  EXPECT_GT(rate.paper, kVideo);
  EXPECT_LT(rate.available, kVideo);
  EXPECT_NEAR(static_cast<double>(only_share(graph, mesh, kVideo)), 0.8242e12, 1e8);
}

TEST(EvaluationTest, SpatialReuseInAChain) {
  const Graph graph = chain({24 * kMega, 11 * kMega, 24 * kMega, 24 * kMega});
  Mesh mesh = bare_mesh();
  const auto available = [&] { return mbit(evaluated(graph, mesh).available); };
  EXPECT_NEAR(available(), 4.632, 5e-4);
  mesh.interference = Interference::explicit_sets;
  mesh.domains = {{.name = "a", .links = {{0, 1}, {1, 2}, {2, 3}}, .origin = {}},
                  {.name = "b", .links = {{1, 2}, {2, 3}, {3, 4}}, .origin = {}}};
  EXPECT_NEAR(available(), 5.739, 5e-4);
  mesh.domains = {{.name = "a", .links = {{0, 1}, {1, 2}}, .origin = {}},
                  {.name = "b", .links = {{1, 2}, {2, 3}}, .origin = {}},
                  {.name = "c", .links = {{2, 3}, {3, 4}}, .origin = {}}};
  EXPECT_NEAR(available(), 7.543, 5e-4);
  // Neighbourhoods: links that share a node conflict, so one in the middle has two neighbours.
  mesh.interference = Interference::k_hop;
  mesh.hops = 0;
  EXPECT_NEAR(available(), 5.739, 5e-4);
  mesh.hops = 1;
  EXPECT_NEAR(available(), 4.632, 5e-4);
}

TEST(EvaluationTest, NamesTheDomainThatLimits) {
  Graph graph = chain({24 * kMega, 11 * kMega});
  graph.links[1].channel = 2;
  Mesh mesh = bare_mesh();
  mesh.interference = Interference::channel;
  EXPECT_EQ(evaluated(graph, mesh).limiting_domain, 1U);
  // 1400 bytes at 11 Mbit/s take 1018181818.2 ps, one part of 10^9 is rounded away.
  EXPECT_EQ(evaluated(graph, mesh).available, 11 * kMega / 8 - 1);
  const auto crowded = [](std::size_t domain) { return domain == 0 ? kFullTime * 9 / 10 : 0; };
  EXPECT_EQ(evaluated(graph, mesh, crowded).limiting_domain, 0U);
  EXPECT_EQ(evaluated(graph, mesh, crowded).available, 24 * kMega / 80 - 1);
}

TEST(EvaluationTest, NoPathCarriesNothing) {
  const Graph graph = chain({kMega});
  const Mesh mesh = bare_mesh();
  const RouteRate rate = evaluate(graph, mesh, Domains(graph, mesh), {}, 100, nothing_taken);
  EXPECT_EQ(rate.paper, 0U);
  EXPECT_EQ(rate.available, 0U);
}

TEST(EvaluationTest, MoreThanTakenAwayLeavesNothing) {
  const Graph graph = chain({kMega});
  const auto full = [](std::size_t) { return kUnbounded; };
  EXPECT_EQ(evaluated(graph, bare_mesh(), full).available, 0U);
}

/// A random mesh with a path.
struct Draw {
  explicit Draw(RandomMesh& random)
      : graph(random.graph(4 + static_cast<std::uint32_t>(random.below(12)), 40)),
        mesh(random.mesh(graph)),
        path(random.path(graph, mesh)),
        event(random.below(4) == 0 ? 0 : 1 + random.below(20'000)) {}

  [[nodiscard]] RouteRate rate(const Taken& taken = nothing_taken) const {
    return evaluate(graph, mesh, Domains(graph, mesh), path, event, taken);
  }

  Graph graph;
  Mesh mesh;
  std::vector<std::uint32_t> path;
  Value event;
};

void for_random_meshes(unsigned seed, const std::function<void(RandomMesh&, Draw&)>& test) {
  RandomMesh random(seed);
  int tested = 0;
  for (int round = 0; round < 600; ++round) {
    Draw draw(random);
    if (draw.path.empty()) continue;
    ++tested;
    test(random, draw);
    if (::testing::Test::HasFatalFailure()) FAIL() << "round " << round;
  }
  ASSERT_GT(tested, 300);
}

/// bytes/s that links of a path can carry of each domain by rates alone: the clique-bound rate.
Value bound_by_rates(const Draw& draw) {
  std::map<std::uint32_t, std::vector<Value>> rates;
  const Domains domains(draw.graph, draw.mesh);
  for (const std::uint32_t link : draw.path)
    for (const std::uint32_t domain : domains.of_link(link))
      rates[domain].push_back(draw.graph.links[link].quality.rate);
  Value least = kUnbounded;
  for (const auto& [domain, in] : rates) least = std::min(least, paper_rate(in) / 8);
  return least;
}

TEST(EvaluationLawTest, AvailableIsNeverAboveWhatTheRatesAloneAllow) {
  for_random_meshes(1, [](RandomMesh&, Draw& draw) {
    const RouteRate rate = draw.rate();
    ASSERT_LE(rate.available, bound_by_rates(draw));
    if (draw.mesh.interference == Interference::single_domain) {
      ASSERT_LE(rate.available, rate.paper);
    }
  });
}

TEST(EvaluationLawTest, AFasterLinkNeverCarriesLess) {
  for_random_meshes(2, [](RandomMesh& random, Draw& draw) {
    const RouteRate before = draw.rate();
    Link& link = draw.graph.links[draw.path[random.below(draw.path.size())]];
    link.quality.rate += 1 + random.below(link.quality.rate);
    const RouteRate after = draw.rate();
    ASSERT_GE(after.available, before.available);
    ASSERT_GE(after.paper, before.paper);
  });
}

TEST(EvaluationLawTest, MoreLossNeverCarriesMore) {
  for_random_meshes(3, [](RandomMesh& random, Draw& draw) {
    const RouteRate before = draw.rate();
    LinkQuality& quality = draw.graph.links[draw.path[random.below(draw.path.size())]].quality;
    quality.loss += random.below(kCertainLoss - quality.loss + 1);
    ASSERT_LE(draw.rate().available, before.available);
  });
}

TEST(EvaluationLawTest, AReservationNeverLeavesMoreAndItsReleaseRestoresExactly) {
  for_random_meshes(4, [](RandomMesh& random, Draw& draw) {
    std::map<std::size_t, Value> ledger;
    const auto taken = [&](std::size_t domain) { return ledger[domain]; };
    const Domains domains(draw.graph, draw.mesh);
    const RouteRate empty = draw.rate(taken);
    Draw other = draw;
    other.path = random.path(draw.graph, draw.mesh);
    const auto flow = shares(draw.graph, draw.mesh, domains, other.path, random.below(1'000'000),
                             random.below(5000));
    for (const Share& share : flow) ledger[share.domain] += share.time;
    ASSERT_LE(draw.rate(taken).available, empty.available);
    for (const Share& share : flow) ledger[share.domain] -= share.time;
    ASSERT_EQ(draw.rate(taken).available, empty.available);
  });
}

TEST(EvaluationLawTest, WhatIsAvailableFitsAndAByteMoreDoesNot) {
  for_random_meshes(5, [](RandomMesh& random, Draw& draw) {
    const Domains domains(draw.graph, draw.mesh);
    std::vector<Value> load(domains.count());
    for (Value& l : load) l = random.below(limit_of(draw.mesh));
    const auto fits = [&](Value demand) {
      return std::ranges::all_of(
          shares(draw.graph, draw.mesh, domains, draw.path, demand, draw.event),
          [&](const Share& s) { return s.time <= limit_of(draw.mesh) - load[s.domain]; });
    };
    const Value most = draw.rate([&](std::size_t d) { return load[d]; }).available;
    ASSERT_TRUE(fits(most)) << most;
    ASSERT_FALSE(fits(most + 1)) << most;
  });
}

TEST(EvaluationLawTest, SharesAreTheSumOfTheLinksInEachDomain) {
  for_random_meshes(6, [](RandomMesh& random, Draw& draw) {
    const Domains domains(draw.graph, draw.mesh);
    const Value demand = random.below(1'000'000);
    std::map<std::uint32_t, Value> expected;
    for (const std::uint32_t link : draw.path)
      for (const std::uint32_t domain : domains.of_link(link))
        expected[domain] +=
            medium_time(draw.graph.links[link].quality, draw.mesh, demand, draw.event);
    const auto found = shares(draw.graph, draw.mesh, domains, draw.path, demand, draw.event);
    ASSERT_EQ(found.size(), expected.size());
    std::uint32_t previous = 0;
    for (const Share& share : found) {
      ASSERT_LE(previous, share.domain) << "rising";
      previous = share.domain;
      // Each link of the sum was rounded up by itself.
      ASSERT_LE(share.time, expected.at(share.domain));
      ASSERT_GE(share.time + draw.path.size(), expected.at(share.domain));
    }
  });
}

TEST(ComposedPerHopTest, LinksAreHopsOnMediaOfTheirOwn) {
  Mesh mesh = bare_mesh();
  mesh.per_hop.set(Attribute::latency, 20'000'000).set(Attribute::bandwidth, 1000);
  mesh.per_hop.set(Attribute::omission, 1).set(Attribute::jitter, 5);
  const Graph graph = chain(std::vector<Value>(3, kMega));
  const AttributeSet three = composed_per_hop(graph, mesh, whole(graph), 0);
  EXPECT_EQ(three[Attribute::latency], 60'000'000U);
  EXPECT_EQ(three[Attribute::jitter], 15U);
  EXPECT_EQ(three[Attribute::bandwidth], 1000U);
  EXPECT_EQ(three[Attribute::omission], 7U) << "(1 + 1)^3 - 1";
  EXPECT_FALSE(three.has(Attribute::packet_loss));
  EXPECT_TRUE(composed_per_hop(graph, mesh, {}, 0).empty());
}

TEST(ComposedPerHopTest, MoreLinksThanARouteHasHops) {
  Mesh mesh = bare_mesh();
  mesh.per_hop.set(Attribute::latency, 7);
  const Graph graph = chain(std::vector<Value>(kMaxPath, kMega));
  EXPECT_EQ(composed_per_hop(graph, mesh, whole(graph), 0)[Attribute::latency], 7 * kMaxPath);
}

TEST(ComposedPerHopTest, TheWorseOfMeasuredAndStatedLossCounts) {
  Mesh mesh = bare_mesh();
  mesh.per_hop.set(Attribute::packet_loss, 100'000'000);
  Graph graph = chain({kMega, kMega});
  graph.links[0].quality.loss = 500'000'000;
  graph.links[0].quality.loss_known = true;
  // 1 - 0.5 * 0.9
  EXPECT_EQ(composed_per_hop(graph, mesh, whole(graph), 0)[Attribute::packet_loss], 550'000'000U);
  mesh.per_hop.clear(Attribute::packet_loss);
  EXPECT_FALSE(composed_per_hop(graph, mesh, whole(graph), 0).has(Attribute::packet_loss))
      << "the loss of the second link is unknown";
  graph.links[1].quality.loss_known = true;
  EXPECT_EQ(composed_per_hop(graph, mesh, whole(graph), 0)[Attribute::packet_loss], 500'000'000U);
}

TEST(ComposedPerHopTest, EveryPacketOfAnEventMustArrive) {
  Mesh mesh = bare_mesh();
  mesh.packet_bytes = 100;
  mesh.per_hop.set(Attribute::packet_loss, 500'000'000);
  const Graph graph = chain({kMega});
  // 1 - 0.5^2
  EXPECT_EQ(composed_per_hop(graph, mesh, whole(graph), 200)[Attribute::packet_loss], 750'000'000U);
  EXPECT_EQ(composed_per_hop(graph, mesh, whole(graph), 100)[Attribute::packet_loss], 500'000'000U);
  EXPECT_EQ(composed_per_hop(graph, mesh, whole(graph), kUnbounded)[Attribute::packet_loss],
            kCertainLoss);
}

}  // namespace
}  // namespace mlcca::core::mesh
