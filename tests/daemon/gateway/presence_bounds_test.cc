// SPDX-License-Identifier: BSD-2-Clause
// Tests that exactly one of several equivalent gateways forwards, except for bounded times,
// whatever fails and whenever.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "tests/daemon/gateway/presence_bench.hpp"

namespace mlcca::test::presence {
namespace {

/// Daemons and programs die at any time and come back, and messages are lost, at most two in a row.
TEST_F(PresenceTest, AtRandomOneForwardsButForBoundedTimes) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    set_up_at_random(seed);
    for (int step = 0; step < 30; ++step) {
      Node& one = *nodes_[below(random_, nodes_.size())];
      const bool last =
          std::ranges::count_if(nodes_, [](const auto& n) { return n->runs() && n->program; }) < 2;
      if (!one.runs())
        one.start();
      else if (!last && chance(random_, 50))
        one.kill();
      else if (!last)
        one.program = false;
      // The bounds hold after each single event.
      none_ = several_ = 0;
      run((100 + below(random_, 8'000)) * kMs);
      ASSERT_LE(longest_several_, kLasts) << "seed " << seed;
      ASSERT_LE(longest_none_, kLasts + kInterval) << "seed " << seed;
      // A gateway that nobody announces does not learn which gateway is back, so systemd starts its
      // program again. What others know must be true before the next one fails.
      if (!std::exchange(one.program, true)) run(kLasts);
    }
  }
}

/// The longest time until a stalled announcer is back. systemd ends and restarts it: WatchdogSec,
/// TimeoutAbortSec and RestartSec of mlcca-famouso.service, and the time of a start.
constexpr Value kBack = 13'000 * kMs;
/// The bound for two failures at once.
constexpr Value kBound = kBack + kInterval;
static_assert(kBack > kLasts);

TEST_F(PresenceTest, WhoseAnnouncerStallsWhileTheOtherOneDiesForwardsOnceItIsBack) {
  for (const std::size_t stalls : {0, 1}) {
    set_up(2);
    run(3'000 * kMs);
    nodes_[stalls]->program = false;
    run(kInterval);
    nodes_[1 - stalls]->kill();
    run(kBack - kInterval);
    EXPECT_EQ(forwarders(), "") << "it cannot know that the other one is dead";
    nodes_[stalls]->program = true;
    run(kInterval + kStep);
    EXPECT_EQ(forwarders(), system_.gateways[stalls].name);
    EXPECT_LE(longest_none_, kBound);
  }
}

/// One announcer stalls, and the other gateways die and come back before and meanwhile.
TEST_F(PresenceTest, AtRandomOneForwardsAlsoWhenTwoFailAtOnceButForBoundedTimes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    set_up_at_random(seed);
    for (int step = 0; step < 10; ++step) {
      Node& stalls = *nodes_[below(random_, nodes_.size())];
      Node& dead = *nodes_[below(random_, nodes_.size())];
      if (&dead != &stalls && chance(random_, 50)) dead.kill();
      none_ = several_ = 0;
      run(2 * kLasts);
      stalls.program = false;
      none_ = several_ = 0;
      for (Value left = kBack; left != 0;) {
        const Value part = std::min(left, (100 + below(random_, 5'000)) * kMs);
        run(part);
        left -= part;
        Node& other = *nodes_[below(random_, nodes_.size())];
        if (&other == &stalls) continue;
        if (other.runs())
          other.kill();
        else
          other.start();
        // The bounds hold after each single event.
        none_ = several_ = 0;
      }
      stalls.program = true;
      run(kBound);
      ASSERT_LE(longest_several_, kBound) << "seed " << seed;
      ASSERT_LE(longest_none_, kBound) << "seed " << seed;
      for (const auto& node : nodes_)
        if (!node->runs()) node->start();
      none_ = several_ = 0;
    }
  }
}

}  // namespace
}  // namespace mlcca::test::presence
