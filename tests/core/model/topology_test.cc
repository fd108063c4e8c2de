// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/topology.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include "core/model/medium.hpp"
#include "tests/core/robot.hpp"

namespace mlcca::core::testing {
namespace {

/// networks 0..n joined in a row by gateways 0..n-1.
System row(std::size_t networks) {
  System system;
  for (std::size_t i = 0; i < networks; ++i) {
    system.networks.push_back(can_network("n" + std::to_string(i)));
    if (i == 0) continue;
    Gateway g;
    g.name = "g" + std::to_string(i);
    g.ports.resize(2);
    g.ports[0].network = i - 1;
    g.ports[1].network = i;
    system.gateways.push_back(g);
  }
  return system;
}

TEST(TopologyTest, AGatewayAtAnEndIsNoHop) {
  const Topology t(row(2));
  const Route& route = t.routes(gateway(0), network(1)).at(0);
  EXPECT_EQ(route.size(), 2U);
  ASSERT_EQ(hops_of(route).size(), 1U);
  EXPECT_EQ(hops_of(route)[0], network(1));
  EXPECT_TRUE(hops_of(t.routes(gateway(0), gateway(0)).at(0)).empty());
}

TEST(TopologyTest, FindsTheLongestAllowedRouteAndNoLonger) {
  // A route over n networks has 2n - 1 hops: 8 networks give 15; 9 would give 17.
  EXPECT_EQ(hops_of(Topology(row(8)).routes(network(0), network(7)).at(0)).size(), 15U);
  EXPECT_TRUE(Topology(row(9)).routes(network(0), network(8)).empty());
  EXPECT_EQ(hops_of(Topology(row(9)).routes(gateway(0), network(8)).at(0)).size(), 15U);
}

TEST(TopologyTest, PutsTheShortestFirstAndNeverLoops) {
  System ring = row(4);
  Gateway close;
  close.name = "close";
  close.ports.resize(2);
  close.ports[0].network = 3;
  close.ports[1].network = 0;
  ring.gateways.push_back(close);
  const Topology t(ring);
  const auto& routes = t.routes(network(0), network(3));
  ASSERT_EQ(routes.size(), 2U);
  EXPECT_EQ(routes[0].size(), 3U);
  EXPECT_EQ(routes[1].size(), 7U);
}

TEST(TopologyTest, StaysBoundedInADenseGraph) {
  System dense;
  for (int i = 0; i < 12; ++i) dense.networks.push_back(can_network("n" + std::to_string(i)));
  for (int g = 0; g < 12; ++g) {
    Gateway gw;
    gw.ports.resize(12);
    for (std::size_t n = 0; n < 12; ++n) gw.ports[n].network = n;
    dense.gateways.push_back(gw);
  }
  EXPECT_EQ(Topology(dense).routes(network(0), network(11)).size(),
            12U + (Topology::kMaxRoutes - 12U));
}

/// Every route without a loop, breadth first: short ones first, equal ones as the ports are listed.
std::vector<Route> all_routes(const System& system, Place from, Place to) {
  std::vector<Route> found;
  std::deque<Route> open{{from}};
  for (; !open.empty(); open.pop_front()) {
    const auto extend = [&](Place next) {
      Route longer = open.front();
      if (std::ranges::find(longer, next) != longer.end()) return;
      longer.push_back(next);
      if (hops_of(longer).size() > kMaxHops) return;
      if (next == to)
        found.push_back(longer);
      else
        open.push_back(longer);
    };
    const Place here = open.front().back();
    for (std::size_t g = 0; g < system.gateways.size(); ++g)
      for (const Port& port : system.gateways[g].ports) {
        if (here == gateway(g)) extend(network(port.network));
        if (here == network(port.network)) extend(gateway(g));
      }
  }
  return found;
}

TEST(TopologyTest, FindsWhatAnExhaustiveSearchFindsInTheSameOrder) {
  std::mt19937 random(7);  // NOLINT(cert-msc51-cpp): the same graphs each time
  const auto below = [&](std::size_t n) { return std::size_t{random()} % n; };
  std::size_t longest = 0;
  for (int round = 0; round < 300; ++round) {
    System system;
    const std::size_t networks = 1 + below(6);
    for (std::size_t n = 0; n < networks; ++n)
      system.networks.push_back(can_network("n" + std::to_string(n)));
    for (std::size_t g = below(6); g > 0; --g) {
      Gateway& added = system.gateways.emplace_back();
      for (std::size_t n = 0; n < networks; ++n)
        if (below(2) == 0) added.ports.emplace_back().network = n;
    }
    const Topology topology(system);
    const auto any_place = [&] {
      const std::size_t i = below(networks + system.gateways.size());
      return i < networks ? network(i) : gateway(i - networks);
    };
    const Place from = any_place();
    const Place to = any_place();
    if (from == to) continue;
    auto expected = all_routes(system, from, to);
    if (expected.size() > Topology::kMaxRoutes) expected.resize(Topology::kMaxRoutes);
    ASSERT_EQ(topology.routes(from, to), expected) << "round " << round;
    if (!expected.empty()) longest = std::max(longest, expected.back().size());
  }
  EXPECT_GT(longest, 6U) << "the graphs are too simple to show it";
}

TEST(MediumTest, CountsFamousoFragments) {
  Network n = can_network("n");
  const Binding& b = n.bindings[0];
  const std::pair<Value, unsigned> cases[] = {
      {0, 1}, {8, 1}, {9, 2}, {14, 2}, {15, 3}, {224, 32}, {225, 33}, {300, 45}, {24608, 4096}};
  for (const auto& [bytes, frames] : cases)
    EXPECT_EQ(frames_per_event(n, &b, bytes), frames) << bytes;
  n.profile = Profile::raw;
  EXPECT_EQ(frames_per_event(n, &b, 100), 1U);
}

}  // namespace
}  // namespace mlcca::core::testing
