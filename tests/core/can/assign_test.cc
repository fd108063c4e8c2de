// SPDX-License-Identifier: BSD-2-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/can/analysis.hpp"
#include "tests/core/can/naive.hpp"
#include "tests/core/can/sets.hpp"

namespace mlcca::core::can {
namespace {

Assumptions bus() {
  Assumptions assumptions;
  assumptions.timing.bitrate = 500'000;
  return assumptions;
}

std::vector<Message> ordered(std::vector<Message> set, const std::vector<std::size_t>& order) {
  for (std::size_t place = 0; place < order.size(); ++place)
    set[order[place]].priority = static_cast<std::uint32_t>(place);
  return set;
}

bool works(const std::vector<Message>& set) {
  for (std::size_t i = 0; i < set.size(); ++i) {
    const auto r = naive::response(set, i, 2000);
    if (!r || *r > set[i].deadline) return false;
  }
  return true;
}

/// Whether the messages work in one of all orders.
template <class Works>
bool any_order_works(const std::vector<Message>& set, const Works& in_order) {
  std::vector<std::size_t> order(set.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  do {
    if (in_order(ordered(set, order))) return true;
  } while (std::ranges::next_permutation(order).found);
  return false;
}

bool all_fit(const Assumptions& assumptions, const std::vector<Message>& set) {
  const auto responses = analyse(assumptions, set);
  for (std::size_t i = 0; i < set.size(); ++i)
    if (!fits(assumptions, set[i], responses[i])) return false;
  return true;
}

TEST(Assign, FindsAnOrderExactlyWhenOneOfAllPermutationsWorks) {
  sets::Random random(1);
  unsigned found = 0;
  unsigned none = 0;
  for (unsigned n = 0; n < 200; ++n) {
    auto set = sets::random_set(random, sets::between(random, 2, 6), {.load = 80});
    // About as long as what can stand in the way: some sets work in a few orders only.
    for (Message& m : set)
      m.deadline = m.jitter + sets::between(random, 200, 1600) * sets::kMicrosecond;
    const bool any = any_order_works(set, works);
    const auto assigned = assign_priorities(bus(), set);
    ASSERT_EQ(assigned.has_value(), any) << n;
    if (assigned) {
      ASSERT_TRUE(works(ordered(set, *assigned))) << n;
    }
    ++(any ? found : none);
  }
  EXPECT_GT(found, 30U);
  EXPECT_GT(none, 30U);
}

TEST(Assign, TheLowestPlaceIsBlockedByNobody) {
  auto set = std::vector{sets::message(0, 1, sets::kMillisecond, 9 * sets::kMillisecond)};
  set[0].deadline = sets::kMillisecond;
  EXPECT_TRUE(assign_priorities(bus(), set));
  set[0].deadline = sets::kMillisecond - 1;
  EXPECT_FALSE(assign_priorities(bus(), set));
}

/// What may be on the bus beside the messages counts at every place.
TEST(Assign, WithErrorsAndOtherLoadTooItFindsAnOrderExactlyWhenOneWorks) {
  auto errors = bus();
  errors.faults = {.count = 1, .interval = 5 * sets::kMillisecond};
  auto load = bus();
  load.background = 50'000;
  auto senders = bus();
  senders.unknown_senders = true;
  for (const Assumptions& assumptions : {errors, load, senders}) {
    sets::Random random(3);
    unsigned found = 0;
    unsigned none = 0;
    for (unsigned n = 0; n < 100; ++n) {
      auto set = sets::random_set(random, sets::between(random, 2, 5), {.load = 60});
      for (Message& m : set)
        m.deadline = m.jitter + sets::between(random, 400, 2800) * sets::kMicrosecond;
      const bool any = any_order_works(
          set, [&](const std::vector<Message>& one) { return all_fit(assumptions, one); });
      const auto assigned = assign_priorities(assumptions, set);
      ASSERT_EQ(assigned.has_value(), any) << n;
      ++(any ? found : none);
    }
    EXPECT_GT(found, 10U);
    EXPECT_GT(none, 10U);
  }
}

TEST(Assign, WithQueuesAndFragmentsAnOrderThatIsFoundHolds) {
  sets::Random random(2);
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::priority, .fifo_depth = 2, .length = 100}};
  unsigned found = 0;
  for (unsigned n = 0; n < 100; ++n) {
    const auto set = sets::random_set(
        random, 6, {.load = 60, .jitter = true, .several_frames = true, .queues = 1});
    const auto order = assign_priorities(assumptions, set);
    if (!order) continue;
    ++found;
    const auto result = ordered(set, *order);
    const auto responses = analyse(assumptions, result);
    for (std::size_t i = 0; i < result.size(); ++i)
      ASSERT_TRUE(fits(assumptions, result[i], responses[i])) << n;
  }
  EXPECT_GT(found, 10U);
}

}  // namespace
}  // namespace mlcca::core::can
