// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/analysis.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/core/can/naive.hpp"
#include "tests/core/can/sets.hpp"
#include "tests/core/can/simulation.hpp"

namespace mlcca::core::can {
namespace {

using sets::kMicrosecond;
using sets::kMillisecond;
using sets::message;
using sets::Random;

Assumptions bus(std::uint32_t bitrate = 500'000) {
  Assumptions assumptions;
  assumptions.timing.bitrate = bitrate;
  return assumptions;
}

/// Table 3 of Davis et al. 2007: 125 kbit/s, 7 bytes each. The analysis of 1994 says 3 ms for C.
std::vector<Message> davis() {
  const Time frame = frame_time({.bitrate = 125'000}, {}, 7);
  std::vector<Message> set = {message(0, 1, frame, 2500 * kMicrosecond),
                              message(1, 2, frame, 3500 * kMicrosecond),
                              message(2, 3, frame, 3500 * kMicrosecond)};
  set[1].deadline = set[2].deadline = 3250 * kMicrosecond;
  return set;
}

TEST(Analysis, TheSecondInstanceIsTheLateOne) {
  const auto set = davis();
  EXPECT_EQ(set[0].transmission, kMillisecond);
  const auto found = analyse(bus(125'000), set);
  EXPECT_EQ(found[0].response, 2 * kMillisecond);
  EXPECT_EQ(found[1].response, 3 * kMillisecond);
  EXPECT_EQ(found[2].response, 3500 * kMicrosecond);
  EXPECT_TRUE(fits(bus(125'000), set[1], found[1]));
  EXPECT_FALSE(fits(bus(125'000), set[2], found[2]));
}

TEST(Analysis, TheLateSecondInstanceIsSeenOnTheBus) {
  const auto set = davis();
  Random random(1);
  simulation::World world;
  world.duration = 20 * kMillisecond;
  const auto events =
      simulation::critical_events(set, 2, world.duration, bit_time({.bitrate = 125'000}));
  const std::vector<unsigned> bands(3, 0);
  const auto seen = simulation::run(bus(125'000), set, bands, events, world, random);
  EXPECT_EQ(seen.response[2], 3500 * kMicrosecond);
}

TEST(Analysis, EqualsTheNaiveFormulas) {
  Random random(2);
  unsigned bounded = 0;
  for (unsigned n = 0; n < 300; ++n) {
    sets::Kind kind;
    kind.load = static_cast<unsigned>(sets::between(random, 20, 95));
    kind.equal_priorities = n % 3 == 0;
    const auto set = sets::random_set(random, sets::between(random, 1, 25), kind);
    const auto found = analyse(bus(), set);
    for (std::size_t i = 0; i < set.size(); ++i) {
      const auto expected = naive::response(set, i, 2000);
      ASSERT_EQ(found[i].bounded, expected.has_value()) << n << ' ' << i;
      if (!expected) continue;
      ++bounded;
      ASSERT_EQ(found[i].response, *expected) << n << ' ' << i;
    }
  }
  EXPECT_GT(bounded, 2000U);
}

Assumptions with_queues() {
  auto assumptions = bus();
  assumptions.queues = {
      {.queueing = Queueing::fifo, .fifo_depth = 2, .length = 10'000},
      {.queueing = Queueing::priority, .fifo_depth = 3, .length = 10'000, .bands = 3}};
  return assumptions;
}

TEST(Analysis, OneMoreMessageNeverMakesAnotherEarlier) {
  Random random(3);
  for (unsigned n = 0; n < 200; ++n) {
    const auto assumptions = with_queues();
    sets::Kind kind{.load = 60,
                    .jitter = true,
                    .several_frames = true,
                    .equal_priorities = n % 2 == 0,
                    .queues = n % 4 == 0 ? 0U : 2U};
    auto set = sets::random_set(random, sets::between(random, 2, 12), kind);
    const auto more = analyse(assumptions, set);
    set.erase(set.begin() + static_cast<std::ptrdiff_t>(set.size() / 2));
    const auto fewer = analyse(assumptions, set);
    for (std::size_t i = 0; i < fewer.size(); ++i) {
      const Response& with = more[i < set.size() / 2 + (set.size() % 2) ? i : i + 1];
      if (!with.bounded) continue;
      ASSERT_TRUE(fewer[i].bounded);
      ASSERT_LE(fewer[i].response, with.response) << n << ' ' << i;
      ASSERT_LE(fewer[i].queued_frames, with.queued_frames) << n << ' ' << i;
    }
  }
}

TEST(Analysis, WorseAssumptionsNeverMakeAMessageEarlier) {
  Random random(4);
  for (unsigned n = 0; n < 100; ++n) {
    const auto set = sets::random_set(
        random, 8, {.load = 40, .jitter = true, .several_frames = true, .queues = 2});
    std::vector<Assumptions> worse(5, with_queues());
    worse[1].unknown_senders = true;
    worse[2].background = 50'000;
    worse[3].faults = {.count = 1, .interval = 20 * kMillisecond};
    worse[4].queues[1].fifo_depth = 9;
    const auto base = analyse(worse[0], set);
    for (std::size_t w = 1; w < worse.size(); ++w) {
      const auto found = analyse(worse[w], set);
      for (std::size_t i = 0; i < set.size(); ++i)
        if (found[i].bounded) {
          ASSERT_TRUE(base[i].bounded);
          ASSERT_GE(found[i].response, base[i].response) << w << ' ' << i;
        }
    }
  }
}

TEST(Analysis, EachFragmentIsBlockedAgainUnlessTheyWaitTogether) {
  auto set = std::vector{message(0, 1, kMillisecond, 100 * kMillisecond),
                         message(1, 2, 2 * kMillisecond, 100 * kMillisecond)};
  set[0].frames = 3;
  set[0].transmission = 3 * kMillisecond;
  EXPECT_EQ(analyse(bus(), set)[0].response, (3 + 2) * kMillisecond) << "there is one to block it";
  set.push_back(message(2, 3, 2 * kMillisecond, 100 * kMillisecond));
  set.push_back(message(3, 4, kMillisecond, 100 * kMillisecond));
  EXPECT_EQ(analyse(bus(), set)[0].response, (3 + 2 + 2 + 1) * kMillisecond);
  set.push_back(message(4, 5, 2 * kMillisecond, 100 * kMillisecond));
  EXPECT_EQ(analyse(bus(), set)[0].response, (3 + 3 * 2) * kMillisecond);
  auto unadmitted = bus();
  unadmitted.unknown_senders = true;
  set.resize(1);
  EXPECT_EQ(analyse(unadmitted, set)[0].response, 3 * kMillisecond + 3 * 320 * kMicrosecond);
  set.push_back(message(1, 2, 2 * kMillisecond, 100 * kMillisecond));
  set[0].back_to_back = true;
  EXPECT_EQ(analyse(bus(), set)[0].response, (3 + 2) * kMillisecond);
}

TEST(Analysis, AnErrorCostsItsFrameAndTheRetransmission) {
  const Time bit = 2 * kMicrosecond;
  const auto set = std::vector{message(0, 1, 100 * bit, 100 * kMillisecond)};
  auto assumptions = bus();
  assumptions.faults = {.count = 2, .interval = 50 * kMillisecond};
  // Two errors, each at the end of a transmission: three transmissions, two error frames. An error
  // frame of before may be on the bus.
  EXPECT_EQ(analyse(assumptions, set)[0].response, (31 + 2 * (31 + 100) + 100) * bit);
}

TEST(Analysis, UnknownSendersBlockWithTheLongestFrame) {
  const auto set = std::vector{message(0, 1, 110 * kMicrosecond, kMillisecond)};
  auto assumptions = bus();
  EXPECT_EQ(analyse(assumptions, set)[0].response, 110 * kMicrosecond);
  assumptions.unknown_senders = true;  // 29 bits, 8 bytes: 160 bits of 2 us
  EXPECT_EQ(analyse(assumptions, set)[0].response, (320 + 110) * kMicrosecond);
}

TEST(Analysis, AFifoMakesTheBestWaitForAllOfItsQueue) {
  auto set = std::vector{message(0, 1, kMillisecond, 100 * kMillisecond),
                         message(1, 2, kMillisecond, 100 * kMillisecond),
                         message(2, 3, kMillisecond, 100 * kMillisecond),
                         message(3, 4, kMillisecond, 100 * kMillisecond)};
  set[0].queue = set[2].queue = 0;
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo}};
  const auto found = analyse(assumptions, set);
  // Blocked by 3, then 2 which came before, then 1 which wins against 2, then itself.
  EXPECT_EQ(found[0].response, 4 * kMillisecond);
  EXPECT_EQ(found[0].queued_frames, 2U);
  assumptions.queues[0].queueing = Queueing::priority;
  set[2].queue = kOwnQueue;
  EXPECT_EQ(analyse(assumptions, set)[0].response, 2 * kMillisecond);
}

TEST(Analysis, AFullQueueDoesNotFit) {
  std::vector<Message> set;
  for (std::uint32_t i = 0; i < 11; ++i) {
    set.push_back(message(i, i, 100 * kMicrosecond, 100 * kMillisecond));
    set.back().queue = 0;
  }
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo, .fifo_depth = 1, .length = 10}};
  auto found = analyse(assumptions, set);
  EXPECT_EQ(found[0].queued_frames, 11U);
  EXPECT_FALSE(fits(assumptions, set[0], found[0]));
  set.pop_back();
  found = analyse(assumptions, set);
  EXPECT_TRUE(fits(assumptions, set[0], found[0]));
}

TEST(Analysis, FragmentsOfAnotherIdentifierCountBothWays) {
  // 0 sends either identifier 1 or, fragmented, identifier 3; message 1 is between them.
  auto set = std::vector{message(0, 1, kMillisecond, 100 * kMillisecond),
                         message(1, 2, kMillisecond, 100 * kMillisecond)};
  set[0].lowest_priority = 3;
  const auto found = analyse(bus(), set);
  EXPECT_EQ(found[0].response, 2 * kMillisecond);  // fragmented, 1 goes first
  EXPECT_EQ(found[1].response,
            3 * kMillisecond);  // blocked by one that is fragmented, then by one that is not
}

// --- senders that pause --------------------------------------------------------------------------

Message paused(std::uint64_t key, std::uint32_t priority, std::uint32_t frames, Time pauses) {
  Message m = message(key, priority, kMillisecond, 1000 * kMillisecond);
  m.frames = frames;
  m.transmission = frames * kMillisecond;
  m.pauses = pauses;
  m.least_pause = 50 * kMillisecond;
  return m;
}

TEST(Analysis, PausesAreAPartOfTheResponse) {
  auto set = std::vector{paused(0, 2, 4, 600 * kMillisecond)};
  EXPECT_EQ(analyse(bus(), set)[0].response, 604 * kMillisecond);
  // Each of the four frames is blocked once by the lower one; the higher one comes seven times.
  set.push_back(message(1, 3, kMillisecond, 1000 * kMillisecond));
  EXPECT_EQ(analyse(bus(), set)[0].response, 608 * kMillisecond);
  set.push_back(message(2, 1, kMillisecond, 100 * kMillisecond));
  EXPECT_EQ(analyse(bus(), set)[0].response, 615 * kMillisecond);
  set[0].jitter = 10 * kMillisecond;
  EXPECT_EQ(analyse(bus(), set)[0].response, 625 * kMillisecond);
  // Lower ones wait for all of its frames, which may come together.
  EXPECT_EQ(analyse(bus(), set)[1].response, 6 * kMillisecond);
  set[0].period = 610 * kMillisecond;
  EXPECT_FALSE(analyse(bus(), set)[0].bounded) << "pauses leave no time for the next event";
}

TEST(Analysis, EventsOfOneSenderWaitForEachOther) {
  auto set = std::vector{paused(0, 1, 4, 300 * kMillisecond), paused(1, 2, 3, 200 * kMillisecond),
                         paused(2, 3, 3, 100 * kMillisecond)};
  set[0].sender = set[1].sender = 5;
  set[2].sender = 6;
  const auto found = analyse(bus(), set);
  // All frames of both, each blocked by the one of the other sender.
  EXPECT_EQ(found[0].response, (7 + 500 + 7) * kMillisecond);
  EXPECT_EQ(found[1].response, found[0].response);
  EXPECT_EQ(found[2].response, (3 + 100 + 7) * kMillisecond);
}

TEST(Analysis, AnAddressHasOneSender) {
  auto set = std::vector{paused(0, 1, 4, 300 * kMillisecond), paused(1, 2, 3, 200 * kMillisecond),
                         paused(2, 3, 3, 100 * kMillisecond)};
  set[0].sender = 5;
  set[1].sender = 5 | 1U << 8U;
  set[2].sender = 6;
  auto found = analyse(bus(), set);
  EXPECT_FALSE(found[0].bounded);
  EXPECT_FALSE(found[1].bounded);
  set[1].sender = 7 | 1U << 8U;
  found = analyse(bus(), set);
  EXPECT_TRUE(found[0].bounded && found[1].bounded && found[2].bounded);
  auto assumptions = bus();
  assumptions.queues = {{}, {}};
  set[0].queue = 0;
  set[1] = paused(1, 2, 3, 200 * kMillisecond);
  set[1].queue = 1;
  set[1].sender = 5;
  EXPECT_FALSE(analyse(assumptions, set)[0].bounded) << "two gateways";
}

TEST(Analysis, WhatAGatewayPausesIsJitterOfItsQueue) {
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::fifo, .fifo_depth = 1, .length = 10}};
  auto set = std::vector{paused(0, 1, 40, 700 * kMillisecond)};
  set[0].queue = 0;
  const auto alone = analyse(assumptions, set);
  EXPECT_EQ(alone[0].response, 740 * kMillisecond);
  EXPECT_EQ(alone[0].queued_frames, 1U) << "each is sent before the next one comes";
  // What comes from another bus has no pauses here, and may have become nearer on the way.
  set[0].pauses = 0;
  set[0].jitter = 100 * kMillisecond;
  const auto forwarded = analyse(assumptions, set);
  EXPECT_EQ(forwarded[0].response, 140 * kMillisecond);
  EXPECT_EQ(forwarded[0].queued_frames, 1 + (40 + 100) / 50U);
  // With another message of the relay's session the pauses add up.
  set[0] = paused(0, 1, 4, 300 * kMillisecond);
  set.push_back(paused(1, 2, 3, 200 * kMillisecond));
  for (Message& m : set) {
    m.queue = 0;
    m.sender = 5;
  }
  EXPECT_EQ(analyse(assumptions, set)[0].response, (500 + 7) * kMillisecond);
}

TEST(Analysis, MessagesWhosePrioritiesOverlapShareABand) {
  auto set = std::vector{message(0, 1, kMillisecond, kMillisecond),
                         message(1, 2, kMillisecond, kMillisecond),
                         message(2, 3, kMillisecond, kMillisecond)};
  for (Message& m : set) m.queue = 0;
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::priority}};
  EXPECT_EQ(bands_of(assumptions, set), (std::vector<unsigned>{0, 1, 2}));
  set[0].lowest_priority = 2;
  EXPECT_EQ(bands_of(assumptions, set), (std::vector<unsigned>{0, 0, 1}));
  set[0].lowest_priority = 9;
  EXPECT_EQ(bands_of(assumptions, set), (std::vector<unsigned>{0, 0, 0}));
}

TEST(Analysis, BandsAreSharedFromTheLastOn) {
  std::vector<Message> set;
  for (std::uint32_t i = 0; i < 5; ++i) {
    set.push_back(message(i, 10 - i, kMillisecond, kMillisecond));
    set.back().queue = 0;
  }
  set[1].priority = set[0].priority;
  auto assumptions = bus();
  assumptions.queues = {{.queueing = Queueing::priority, .bands = 3}};
  EXPECT_EQ(bands_of(assumptions, set), (std::vector<unsigned>{2, 2, 2, 1, 0}));
}

TEST(Analysis, NothingIsBoundedAtFullLoad) {
  const auto set = std::vector{message(0, 1, 500 * kMicrosecond, kMillisecond),
                               message(1, 2, 500 * kMicrosecond, kMillisecond)};
  const auto found = analyse(bus(), set);
  EXPECT_TRUE(found[0].bounded);
  EXPECT_FALSE(found[1].bounded);
  EXPECT_EQ(utilisation_ppm(bus(), set), 1'000'000U);
}

TEST(Analysis, LimitsEndTheSearch) {
  // So near full load that the busy period has more instances than are analysed.
  auto set =
      std::vector{message(0, 1, 499'990, kMillisecond), message(1, 2, 500'000, kMillisecond + 7)};
  set[0].jitter = 5 * kMillisecond;
  EXPECT_FALSE(analyse(bus(), set)[1].bounded);
  // The bus is lost to errors.
  auto assumptions = bus();
  assumptions.faults = {.count = std::numeric_limits<std::uint32_t>::max(), .interval = 1};
  EXPECT_FALSE(analyse(assumptions, set)[0].bounded);
  assumptions.faults = {};
  assumptions.background = std::numeric_limits<std::uint32_t>::max();
  EXPECT_FALSE(analyse(assumptions, set)[0].bounded);
}

TEST(Analysis, WhatCannotBeAnalysedLeavesNothingBounded) {
  const auto good = message(0, 1, kMillisecond, 10 * kMillisecond);
  std::vector<Message> bad(6, message(1, 2, kMillisecond, 10 * kMillisecond));
  bad[0].period = 0;
  bad[1].transmission = bad[1].longest_frame = bad[1].last_frame = kNever;
  bad[2].frames = 0;
  bad[3].queue = 0;  // there is none
  bad[4].last_frame = 0;
  bad[5].longest_frame = 2 * kMillisecond;
  for (const Message& m : bad) {
    const auto found = analyse(bus(), std::vector{good, m});
    EXPECT_FALSE(found[0].bounded);
    EXPECT_FALSE(found[1].bounded);
  }
  EXPECT_FALSE(analyse(bus(0), std::vector{good})[0].bounded);
}

TEST(Analysis, TooMuchJitterLeavesUnboundedWhatItMayWinAgainst) {
  auto set = std::vector{message(0, 1, kMillisecond, 10 * kMillisecond),
                         message(1, 2, kMillisecond, 10 * kMillisecond),
                         message(2, 3, kMillisecond, 10 * kMillisecond)};
  for (const Time jitter : {kLongestTime + 1, kNever}) {
    set[1].jitter = jitter;
    for (const bool fragmented : {false, true}) {
      set[1].frames = fragmented ? 2 : 1;
      const auto found = analyse(bus(), set);
      ASSERT_TRUE(found[0].bounded);
      EXPECT_EQ(found[0].response, 2 * kMillisecond);
      EXPECT_FALSE(found[1].bounded);
      EXPECT_FALSE(found[2].bounded);
      EXPECT_EQ(utilisation_ppm(bus(), set), 300'000U);
    }
  }
}

/// 6 frames of 8 bytes in 3.4 ms at 500 kbit/s, under each of which a frame of 29 bits may begin.
TEST(Analysis, ASenderOfOneFrameAtATimeIsBlockedBeforeEachFrameOfEachEvent) {
  auto set = std::vector{message(0, 1, 270 * kMicrosecond, 3400 * kMicrosecond)};
  set[0].frames = 6;
  set[0].transmission = 6 * set[0].longest_frame;
  for (std::uint32_t i = 1; i <= 12; ++i)
    set.push_back(message(i, 1 + i, 320 * kMicrosecond, 100 * kMillisecond));
  // The first event takes six times 320 and 270 us, and the next one waits already. Then all of
  // the others have been sent.
  EXPECT_EQ(analyse(bus(), set)[0].response, (12 * (320 + 270) - 3400) * kMicrosecond);
  auto unadmitted = bus();
  unadmitted.unknown_senders = true;  // they always have another one
  EXPECT_FALSE(analyse(unadmitted, set)[0].bounded);
  set[0].back_to_back = true;
  EXPECT_EQ(analyse(bus(), set)[0].response, (320 + 6 * 270) * kMicrosecond);
  set[0].back_to_back = false;
  set[0].period = 3540 * kMicrosecond;
  EXPECT_EQ(analyse(bus(), set)[0].response, 3540 * kMicrosecond);
}

TEST(Analysis, LongestNumbersDoNotOverflow) {
  auto slow = message(0, 1, kLongestTime / 4, std::numeric_limits<Time>::max());
  auto late = message(1, 2, kMillisecond, kLongestTime);
  late.jitter = kLongestTime / 2;
  slow.deadline = late.deadline = std::numeric_limits<Time>::max();
  const auto found = analyse(bus(), std::vector{slow, late});
  ASSERT_TRUE(found[0].bounded);
  EXPECT_EQ(found[0].response, kLongestTime / 4 + kMillisecond);
  ASSERT_TRUE(found[1].bounded);
  EXPECT_EQ(found[1].response, kLongestTime / 2 + kLongestTime / 4 + kMillisecond);
}

}  // namespace
}  // namespace mlcca::core::can
