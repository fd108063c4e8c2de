// SPDX-License-Identifier: BSD-2-Clause
// A shared network changes, and with it what others hold of it.
#include <gtest/gtest.h>

#include "core/mesh/domains.hpp"
#include "tests/core/shared/gateways.hpp"

namespace mlcca::core::testing {
namespace {

enum class Becomes : std::uint8_t { loaded, faster, unavailable };

Condition condition_of(Becomes what) {
  Condition condition;
  if (what == Becomes::loaded) condition.background = 10'000;
  if (what == Becomes::faster) condition.timing.bitrate = 250'000;
  condition.available = what != Becomes::unavailable;
  return condition;
}

class SameRoundTest : public ::testing::TestWithParam<Becomes> {};

/// What another gateway begins to hold in the round in which the bus changes is not forgotten.
TEST_P(SameRoundTest, WhatOthersBeginToHoldOfABusThatChangesCounts) {
  System system = networks(false);
  const std::size_t c = add_channel(system, every(50 * kMs));
  const std::size_t d = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  Pair pair(system);
  ASSERT_TRUE(pair[1].admit(both_ends(d, 1, every(50 * kMs), 1)));
  State& state = pair[0].state;
  const std::size_t before = messages_on(state, kShared).size();
  state.set_condition(kShared, condition_of(GetParam()));
  pair[0].read();
  EXPECT_EQ(messages_on(state, kShared).size(), before + 1);
  state.set_condition(kShared, {});
  pair[1].release(1);
  pair[0].read();
  EXPECT_EQ(messages_on(state, kShared).size(), before) << "and neither is that it has ended";
}

/// The same where this gateway decides alone, as far as it knows.
TEST_P(SameRoundTest, WithoutPermitsAsWell) {
  System system = networks(false);
  const std::size_t d = add_channel(system, every(50 * kMs));
  Pair pair(system);
  ASSERT_TRUE(pair[1].admit(both_ends(d, 1, every(50 * kMs), 1)));
  State alone(system);
  alone.set_condition(kShared, condition_of(GetParam()));
  alone.set_foreign(kShared, pair.store.without(0, kShared));
  static_cast<void>(alone.settle());
  EXPECT_EQ(messages_on(alone, kShared).size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Bus, SameRoundTest,
                         ::testing::Values(Becomes::loaded, Becomes::faster, Becomes::unavailable));

/// There is room for what this gateway has, and not for what another one has beside it, because the
/// medium is measured as busy. The order in which the two become known does not matter.
TEST(BusyMeshTest, WhatIsMeasuredAsBusyLeavesLessForOthers) {
  System system = networks(true);
  const std::size_t c = add_channel(system, every(50 * kMs));
  describe(system, c, every(50 * kMs));
  system.publishers.back().place = at(0);
  system.subscribers.back().place = on(kAir);
  const World described = described_world(system);
  const MeshView& view = *described.meshes[kAir];
  const Value whole = mesh::limit_of(*system.networks[kAir].mesh);
  const Value one =
      mesh::shares(view.graph, *system.networks[kAir].mesh, view.domains(), view.path(0, 1), 160, 8)
          .front()
          .time;
  ASSERT_LT(one, whole / 4);
  const auto decided = [&](bool others_first) {
    Pair pair(system);
    State& state = pair[0].state;
    mesh::Graph busy = described.meshes[kAir]->graph;
    // Room for one event more, and for none with what the other one takes.
    for (mesh::Link& link : busy.links)
      link.busy = static_cast<Value>(((whole - one - one / 2) * 1'000'000) / mesh::kFullTime);
    cluster::Foreign foreign;
    foreign.paths.push_back({.from = 1,
                             .to = 0,
                             .bytes_per_second = 160,
                             .event_bytes = 8,
                             .source = {.publisher = 0, .admission = 4},
                             .gateway = 1});
    foreign.rates.push_back(
        {.bytes_per_second = 160, .source = {.publisher = 0, .admission = 4}, .gateway = 1});
    if (others_first) {
      state.set_foreign(kAir, foreign);
      static_cast<void>(state.settle());
    }
    state.set_graph(kAir, busy);
    static_cast<void>(state.settle());
    if (!others_first) {
      EXPECT_TRUE(granted(state, c)) << "it has room alone: " << why(state, c);
      state.set_foreign(kAir, foreign);
      static_cast<void>(state.settle());
    }
    return granted(state, c);
  };
  EXPECT_FALSE(decided(true));
  EXPECT_FALSE(decided(false));
}

}  // namespace
}  // namespace mlcca::core::testing
