// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/core/can/sets.hpp"

namespace mlcca::core::can {
namespace {

using sets::kMillisecond;
using sets::message;
using sets::Random;

Assumptions bus() {
  Assumptions assumptions;
  assumptions.timing.bitrate = 500'000;
  return assumptions;
}

/// Whether the analysis of everything at once says that all is in time.
bool all_fit(const Assumptions& assumptions, const std::vector<Message>& set) {
  const auto found = analyse(assumptions, set);
  for (std::size_t i = 0; i < set.size(); ++i)
    if (!fits(assumptions, set[i], found[i])) return false;
  return true;
}

/// Adds and removes at random; every answer must be the one of the whole analysis.
void add_and_remove(const Assumptions& assumptions, const sets::Kind& kind, unsigned seed,
                    unsigned steps) {
  Random random(seed);
  Schedule schedule(assumptions);
  std::map<std::uint64_t, Message> there;
  unsigned granted = 0;
  unsigned refused = 0;
  std::uint64_t key = 0;
  const auto pool = sets::random_set(random, 60, kind);
  for (unsigned step = 0; step < steps; ++step) {
    if (!there.empty() && random() % 5 < 2) {
      const auto victim =
          std::next(there.begin(), static_cast<std::ptrdiff_t>(random() % there.size()));
      schedule.remove(victim->first);
      there.erase(victim);
    } else {
      Message m = pool[random() % pool.size()];
      m.key = ++key;
      m.period /= sets::between(random, 1, 3);
      m.deadline = m.jitter + m.period * sets::between(random, 5, 30) / 10;
      const Schedule before = schedule;
      std::vector<Message> all{m};
      for (const auto& [k, v] : there) all.push_back(v);
      const auto late = schedule.add(m);
      ASSERT_EQ(!late, all_fit(assumptions, all)) << "step " << step;
      if (late) {
        ++refused;
        ASSERT_EQ(schedule, before);
        const auto found = analyse(assumptions, all);
        const auto at = static_cast<std::size_t>(std::ranges::find(all, late->key, &Message::key) -
                                                 all.begin());
        ASSERT_LT(at, all.size());
        ASSERT_FALSE(fits(assumptions, all[at], found[at]));
        ASSERT_EQ(late->bounded, found[at].bounded);
        if (late->bounded) {
          ASSERT_EQ(late->response, found[at].response);
        }
        ASSERT_EQ(late->deadline, all[at].deadline);
      } else {
        ++granted;
        there.emplace(m.key, m);
      }
    }
    ASSERT_EQ(schedule.messages().size(), there.size());
    ASSERT_TRUE(std::ranges::is_sorted(
        schedule.messages(), {}, [](const Message& m) { return std::pair(m.priority, m.key); }));
    if (step % 10 != 0) continue;
    const auto found = analyse(assumptions, schedule.messages());
    for (std::size_t i = 0; i < found.size(); ++i)
      ASSERT_EQ(schedule.response(schedule.messages()[i].key), found[i].response);
    Schedule fresh(assumptions);
    for (const auto& [k, v] : there) ASSERT_FALSE(fresh.add(v));
    ASSERT_EQ(fresh, schedule);
  }
  EXPECT_GT(granted, 20U);
  EXPECT_GT(refused, 20U);
}

TEST(Schedule, AnswersLikeTheWholeAnalysisForPlainMessages) {
  add_and_remove(bus(), {.load = 250}, 1, 600);
}

TEST(Schedule, AnswersLikeTheWholeAnalysisWithEqualPriorities) {
  add_and_remove(bus(), {.load = 250, .equal_priorities = true}, 2, 600);
}

TEST(Schedule, AnswersLikeTheWholeAnalysisWithOverhead) {
  auto assumptions = bus();
  assumptions.unknown_senders = true;
  assumptions.background = 20'000;
  assumptions.faults = {.count = 1, .interval = 20 * kMillisecond};
  add_and_remove(assumptions, {.load = 250}, 3, 400);
}

TEST(Schedule, AnswersLikeTheWholeAnalysisWithQueuesAndFragments) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo, .fifo_depth = 1, .length = 8},
                        {.queueing = Queueing::priority, .fifo_depth = 2, .length = 20}};
  add_and_remove(assumptions, {.load = 150, .several_frames = true, .queues = 2}, 4, 300);
}

TEST(Schedule, NamesWhatWouldBeLate) {
  Schedule schedule(bus());
  auto tight = message(1, 1, kMillisecond, 20 * kMillisecond);
  tight.deadline = 2 * kMillisecond;
  ASSERT_FALSE(schedule.add(tight));
  // A long frame of low priority is in time, and makes the tight one late.
  const auto late = schedule.add(message(2, 9, 2 * kMillisecond, 100 * kMillisecond));
  ASSERT_TRUE(late);
  EXPECT_EQ(late->key, 1U);
  EXPECT_EQ(late->response, 3 * kMillisecond);
  EXPECT_TRUE(late->bounded);
  EXPECT_EQ(late->deadline, 2 * kMillisecond);
  EXPECT_FALSE(schedule.contains(2));
  EXPECT_EQ(schedule.response(1), kMillisecond);
  EXPECT_EQ(schedule.response(2), kNever);
}

TEST(Schedule, WithOtherAssumptionsItNamesWhatIsLate) {
  Schedule schedule(bus());
  auto tight = message(1, 1, kMillisecond, 20 * kMillisecond);
  tight.deadline = 1200 * sets::kMicrosecond;
  ASSERT_FALSE(schedule.add(tight));
  ASSERT_FALSE(schedule.add(message(2, 2, 100 * sets::kMicrosecond, 50 * kMillisecond)));
  EXPECT_TRUE(schedule.late().empty());
  auto unadmitted = bus();
  unadmitted.unknown_senders = true;
  const auto late = schedule.set_assumptions(unadmitted);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].key, 1U);
  EXPECT_EQ(schedule.late(), late);
  EXPECT_EQ(schedule.messages().size(), 2U);
  // Nothing is granted beside what is late already.
  EXPECT_TRUE(schedule.add(message(3, 3, 100 * sets::kMicrosecond, 50 * kMillisecond)));
  schedule.remove(1);
  EXPECT_TRUE(schedule.late().empty());
  EXPECT_FALSE(schedule.add(message(3, 3, 100 * sets::kMicrosecond, 50 * kMillisecond)));
}

/// Where an analysis ended with more on the bus is no beginning for the next one.
TEST(Schedule, WithLessOnTheBusEverythingIsAsItWouldHaveBeen) {
  auto busy = bus();
  busy.background = 300'000;
  auto quieter = bus();
  quieter.background = 1'000;
  Random random(5);
  unsigned refused = 0;
  for (int round = 0; round < 300; ++round) {
    const auto pool = sets::random_set(random, 30, {.load = 150, .equal_priorities = true});
    Schedule schedule(busy);
    std::size_t next = 0;
    while (next < pool.size() / 2) static_cast<void>(schedule.add(pool[next++]));
    ASSERT_TRUE(schedule.set_assumptions(quieter).empty());
    Schedule fresh(quieter);
    for (const Message& m : schedule.messages()) ASSERT_FALSE(fresh.add(m));
    for (; next < pool.size(); ++next) {
      const auto late = schedule.add(pool[next]);
      ASSERT_EQ(late, fresh.add(pool[next])) << round;
      if (late) ++refused;
    }
  }
  EXPECT_GT(refused, 300U);
}

/// The second instance of the lowest is later than the first one (Davis and others, Real-Time
/// Systems 35, 2007, table 3), and here both may be queued at the same moment.
TEST(Schedule, AJitterLongerThanThePeriodLeavesTheLaterInstancesLate) {
  constexpr Time us = sets::kMicrosecond;
  Schedule schedule(bus());
  ASSERT_FALSE(schedule.add(message(1, 1, 1000 * us, 2500 * us)));
  ASSERT_FALSE(schedule.add(message(2, 2, 1000 * us, 3500 * us)));
  auto lowest = message(3, 3, 1000 * us, 3500 * us);
  lowest.jitter = 3600 * us;
  lowest.deadline = 6850 * us;
  const auto late = schedule.add(lowest);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->key, 3U);
  EXPECT_EQ(late->response, 7100 * us);
}

/// A longer frame below blocks all above for longer: they are analysed, too.
TEST(Schedule, ALongerFrameBelowAllOthersMayMakeThemLate) {
  constexpr Time us = sets::kMicrosecond;
  Schedule schedule(bus());
  auto first = message(1, 1, 100 * us, 10 * kMillisecond);
  first.deadline = 300 * us;
  ASSERT_FALSE(schedule.add(first));
  ASSERT_FALSE(schedule.add(message(2, 2, 200 * us, 10 * kMillisecond)));
  ASSERT_FALSE(schedule.add(message(3, 3, 200 * us, 10 * kMillisecond)));
  const auto late = schedule.add(message(4, 4, 202 * us, 10 * kMillisecond));
  ASSERT_TRUE(late);
  EXPECT_EQ(late->key, 1U);
}

TEST(Schedule, AnUnknownBitRateGrantsNothing) {
  Schedule none;
  const auto late = none.add(message(1, 1, kMillisecond, 20 * kMillisecond));
  ASSERT_TRUE(late);
  EXPECT_FALSE(late->bounded);
  Schedule schedule(bus());
  ASSERT_FALSE(schedule.add(message(1, 1, kMillisecond, 20 * kMillisecond)));
  EXPECT_EQ(schedule.set_assumptions({}).size(), 1U);
  EXPECT_TRUE(schedule.set_assumptions(bus()).empty());
  EXPECT_FALSE(schedule.add(message(2, 2, kMillisecond, 20 * kMillisecond)));
}

TEST(Schedule, AFullQueueIsNamed) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo, .fifo_depth = 1, .length = 1}};
  Schedule schedule(assumptions);
  auto m = message(1, 1, kMillisecond, 20 * kMillisecond);
  m.queue = 0;
  ASSERT_FALSE(schedule.add(m));
  m.key = 2;
  const auto late = schedule.add(m);
  ASSERT_TRUE(late);
  EXPECT_TRUE(late->overflow);
}

}  // namespace
}  // namespace mlcca::core::can
