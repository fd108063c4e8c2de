// SPDX-License-Identifier: BSD-2-Clause
// No simulated bus may ever be later than the analysis says.
#include "tests/core/can/simulation.hpp"

#include <gtest/gtest.h>

#include "core/can/analysis.hpp"
#include "tests/core/can/sets.hpp"

namespace mlcca::core::can {
namespace {

using sets::Kind;
using sets::random_set;
using simulation::Random;

/// So that a test sees that it tests something.
struct Tally {
  unsigned sets = 0;
  unsigned bounded = 0;  ///< messages
  std::uint64_t errors = 0;
};

void check_set(const Assumptions& assumptions, const std::vector<Message>& set, Random& random,
               Tally& tally) {
  const auto responses = analyse(assumptions, set);
  const auto bands = bands_of(assumptions, set);
  ++tally.sets;
  Time slowest = 0;
  for (const Message& m : set) slowest = std::max(slowest, m.period);
  for (unsigned attempt = 0; attempt < 6; ++attempt) {
    simulation::World world;
    world.duration = slowest * 8;
    world.late_blocker = assumptions.unknown_senders;
    world.error_chance = 30 * (1 + attempt % 3);
    world.background_wins = attempt % 2 == 0;
    const auto events =
        attempt % 3 == 0 ? simulation::critical_events(set, random() % set.size(), world.duration,
                                                       bit_time(assumptions.timing))
                         : simulation::random_events(set, world.duration, random);
    const auto seen = simulation::run(assumptions, set, bands, events, world, random);
    tally.errors += seen.errors;
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (!responses[i].bounded) continue;
      ASSERT_LE(seen.response[i], responses[i].response)
          << "message " << i << " of set " << tally.sets << ", priority " << set[i].priority
          << ", queue " << set[i].queue;
      if (set[i].queue != kOwnQueue) {
        ASSERT_LE(seen.most_queued[set[i].queue], responses[i].queued_frames)
            << "queue " << set[i].queue << " of set " << tally.sets;
      }
    }
  }
  for (const Response& r : responses) tally.bounded += r.bounded ? 1 : 0;
}

Tally check_sets(const Assumptions& assumptions, const Kind& kind, unsigned seed,
                 unsigned count = 150) {
  Random random(seed);
  Tally tally;
  for (unsigned i = 0; i < count && !::testing::Test::HasFatalFailure(); ++i) {
    Kind one = kind;
    one.load = static_cast<unsigned>(sets::between(random, 20, kind.load));
    check_set(assumptions, random_set(random, sets::between(random, 2, 12), one), random, tally);
  }
  EXPECT_GT(tally.bounded, tally.sets) << "hardly anything is bounded, so hardly anything tested";
  return tally;
}

Assumptions bus() {
  Assumptions assumptions;
  assumptions.timing.bitrate = 500'000;
  return assumptions;
}

TEST(Simulation, PlainMessages) { check_sets(bus(), {.load = 95, .jitter = false}, 1); }

TEST(Simulation, BoundsOfPlainMessagesAreReachedAtTheirCriticalInstant) {
  Random random(40);
  unsigned bounded = 0;
  unsigned reached = 0;
  const Time bit = bit_time(bus().timing);
  for (unsigned n = 0; n < 200; ++n) {
    Kind kind;
    kind.load = static_cast<unsigned>(sets::between(random, 20, 95));
    auto set = random_set(random, sets::between(random, 2, 12), kind);
    const auto responses = analyse(bus(), set);
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (!responses[i].bounded || responses[i].response > 40 * set[i].period) continue;
      ++bounded;
      simulation::World world;
      world.duration = 2 * responses[i].response + 2 * set[i].period;
      for (const Message& m : set) world.duration += m.jitter;
      const auto events = simulation::critical_events(set, i, world.duration, bit);
      const auto bands = bands_of(bus(), set);
      const auto seen = simulation::run(bus(), set, bands, events, world, random);
      ASSERT_LE(seen.response[i], responses[i].response) << "set " << n << ", message " << i;
      if (seen.response[i] + 2 * bit >= responses[i].response) ++reached;
    }
  }
  EXPECT_GT(bounded, 800U);
  // The blocking frame began a bit before the instant. Where a frame comes within just that bit, it
  // loses here, while it would win against a blocking frame that began any less before.
  EXPECT_GE(reached, bounded - bounded / 100);
}

TEST(Simulation, Jitter) { check_sets(bus(), {.load = 90}, 2); }

TEST(Simulation, EqualPriorities) { check_sets(bus(), {.load = 90, .equal_priorities = true}, 3); }

TEST(Simulation, EventsOfSeveralFrames) {
  check_sets(bus(), {.load = 80, .several_frames = true}, 4);
}

TEST(Simulation, UnknownSenders) {
  auto assumptions = bus();
  assumptions.unknown_senders = true;
  check_sets(assumptions, {.load = 80, .several_frames = true}, 5);
}

TEST(Simulation, Background) {
  auto assumptions = bus();
  assumptions.background = 100'000;
  check_sets(assumptions, {.load = 70, .several_frames = true}, 6);
}

TEST(Simulation, Errors) {
  auto assumptions = bus();
  assumptions.faults = {.count = 2, .interval = 5 * sets::kMillisecond};
  const auto tally = check_sets(assumptions, {.load = 50, .several_frames = true}, 7);
  EXPECT_GT(tally.errors, 1000U);
}

TEST(Simulation, ErrorsWithUnknownSendersAndBackground) {
  auto assumptions = bus();
  assumptions.faults = {.count = 1, .interval = 3 * sets::kMillisecond};
  assumptions.unknown_senders = true;
  assumptions.background = 50'000;
  check_sets(assumptions, {.load = 50, .several_frames = true}, 8);
}

TEST(Simulation, OneFifoQueue) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo, .fifo_depth = 1}};
  check_sets(assumptions, {.load = 80, .several_frames = true, .queues = 1}, 9);
}

TEST(Simulation, SeveralFifoQueuesWithErrors) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo, .fifo_depth = 1},
                        {.queueing = Queueing::fifo, .fifo_depth = 4}};
  check_sets(assumptions, {.load = 60, .several_frames = true, .queues = 2}, 10);
  assumptions.faults = {.count = 1, .interval = 5 * sets::kMillisecond};
  check_sets(assumptions, {.load = 40, .several_frames = true, .queues = 2}, 11);
}

TEST(Simulation, PriorityQueuesOfEveryDepth) {
  for (const unsigned depth : {1U, 2U, 3U, 8U}) {
    auto assumptions = bus();
    assumptions.queues = {{.queueing = Queueing::priority, .fifo_depth = depth}};
    check_sets(assumptions, {.load = 85, .several_frames = true, .queues = 1}, 20 + depth);
  }
}

TEST(Simulation, PriorityQueuesWithSharedBands) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::priority, .fifo_depth = 2, .bands = 3}};
  check_sets(assumptions,
             {.load = 80, .several_frames = true, .equal_priorities = true, .queues = 1}, 30);
}

TEST(Simulation, QueuesOfBothKindsWithEverythingElse) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::priority, .fifo_depth = 2},
                        {.queueing = Queueing::fifo, .fifo_depth = 3},
                        {.queueing = Queueing::priority, .fifo_depth = 1, .bands = 2}};
  assumptions.unknown_senders = true;
  assumptions.background = 30'000;
  assumptions.faults = {.count = 1, .interval = 10 * sets::kMillisecond};
  check_sets(assumptions, {.load = 45, .several_frames = true, .queues = 3}, 31);
}

}  // namespace
}  // namespace mlcca::core::can
