// SPDX-License-Identifier: BSD-2-Clause
// What the real gate programs find about the events of a slot. No test waits: a gap is as long
// as the test says, because it puts back the time of the latest event.
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <numeric>
#include <thread>
#include <vector>

#include "base/clock.hpp"
#include "tests/bpf/one_slot.hpp"

namespace mlcca::test {
namespace {

using gates::Direction;
using gates::SlotSpec;

constexpr std::uint64_t kPeriod = 8'000'000'000;  // ns
constexpr std::uint64_t kEighth = kPeriod / 8;
constexpr std::uint64_t kSoon = 500'000'000;  // ns; longer than a frame takes

SlotSpec watched(std::uint64_t period, std::uint64_t together = 0) {
  SlotSpec s = one_slot();
  s.period = period;
  s.together = together;
  return s;
}

class Watch : public OneSlot {
 protected:
  /// A frame `gap` after the latest one, and a little.
  void passes_after(std::uint64_t gap) {
    watch().last = monotonic_ns() - gap;
    ASSERT_TRUE(passes());
  }
  gate_watch& watch() { return gate_.table().watches[slot_]; }
  std::uint64_t gaps() {
    return std::accumulate(std::begin(watch().gaps), std::end(watch().gaps), std::uint64_t{0});
  }
};

TEST_F(Watch, TheFirstEventHasNoGap) {
  admit(watched(kPeriod));
  const std::uint64_t before = monotonic_ns();
  ASSERT_TRUE(passes());
  EXPECT_GE(watch().last, before);
  EXPECT_LE(watch().last, monotonic_ns());
  EXPECT_EQ(gaps(), 0U);
  EXPECT_EQ(watch().last_gap, 0U);
}

TEST_F(Watch, CountsGapsByEighthsOfThePeriod) {
  admit(watched(kPeriod));
  for (unsigned eighth = 0; eighth < 20; ++eighth) {
    const unsigned bin = std::min(eighth, GATE_GAPS - 1U);
    const std::uint64_t before = watch().gaps[bin];
    passes_after(eighth * kEighth);
    EXPECT_EQ(watch().gaps[bin], before + 1) << eighth;
    // Just below the next one.
    passes_after((eighth + 1) * kEighth - kSoon);
    EXPECT_EQ(watch().gaps[bin], before + 2) << eighth;
  }
}

TEST_F(Watch, CountsWhatIsMissingInBetween) {
  admit(watched(kPeriod));
  passes_after(kPeriod + 3 * kEighth);
  EXPECT_EQ(watch().missing, 0U) << "late, not missing";
  passes_after(kPeriod + 4 * kEighth);
  EXPECT_EQ(watch().missing, 1U) << "a period and a half";
  passes_after(2 * kPeriod + 3 * kEighth);
  EXPECT_EQ(watch().missing, 2U);
  passes_after(10 * kPeriod);
  EXPECT_EQ(watch().missing, 11U);
}

TEST_F(Watch, RestartsAfterASilence) {
  constexpr std::uint64_t period = 50'000'000;
  SlotSpec s = watched(period);
  s.silence = 3 * period;
  admit(s);
  ASSERT_TRUE(passes());
  passes_after(GATE_RECOVERY_HOLD - kSoon);
  EXPECT_GE(watch().missing, 9U) << "loss, although it is an exception: events come again at once";
  EXPECT_EQ(gaps(), 1U);
  const std::uint64_t before = monotonic_ns();
  passes_after(GATE_RECOVERY_HOLD);
  EXPECT_EQ(watch().missing, 0U);
  EXPECT_EQ(gaps(), 0U);
  EXPECT_EQ(watch().last_gap, 0U);
  EXPECT_EQ(watch().shortest, 0U);
  EXPECT_EQ(watch().longest, 0U);
  EXPECT_EQ(watch().deviation, 0U);
  EXPECT_GE(watch().first, before);
}

TEST_F(Watch, WithoutASilenceTimerIsSilentForSixteenPeriods) {
  admit(watched(kPeriod));
  ASSERT_TRUE(passes());
  passes_after(GATE_SILENT_PERIODS * kPeriod - kSoon);
  EXPECT_EQ(watch().missing, GATE_SILENT_PERIODS - 1U);
  passes_after(GATE_SILENT_PERIODS * kPeriod);
  EXPECT_EQ(watch().missing, 0U);
}

TEST_F(Watch, KnowsTheExtremesAndHowFarOffTheyAre) {
  admit(watched(kPeriod));
  passes_after(kPeriod);
  EXPECT_GE(watch().last_gap, kPeriod);
  EXPECT_LT(watch().deviation, kSoon);
  passes_after(5 * kEighth);
  passes_after(9 * kEighth);
  EXPECT_GE(watch().shortest, 5 * kEighth);
  EXPECT_LT(watch().shortest, 5 * kEighth + kSoon);
  EXPECT_GE(watch().longest, 9 * kEighth);
  EXPECT_LE(watch().deviation, 3 * kEighth);
  EXPECT_GT(watch().deviation, 3 * kEighth - kSoon);
  passes_after(3 * kPeriod + kEighth);
  EXPECT_GE(watch().longest, 3 * kPeriod);
  EXPECT_LE(watch().deviation, 3 * kEighth) << "an eighth off, and two are missing";
}

TEST_F(Watch, FramesOfOneEventAreOneEvent) {
  admit(watched(kPeriod, kPeriod / 2));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(passes());
  EXPECT_EQ(gaps(), 0U);
  passes_after(kPeriod);
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(passes());
  EXPECT_EQ(gaps(), 1U);
  EXPECT_GE(watch().shortest, kPeriod);
}

TEST_F(Watch, WhatIsDroppedIsNoEvent) {
  SlotSpec s = watched(kPeriod);
  s.per_frame = kPeriod;
  admit(s);
  ASSERT_TRUE(passes());
  ASSERT_FALSE(passes()) << "more than was admitted";
  EXPECT_EQ(gaps(), 0U);
  s.excess_passes = true;
  admit(s);
  ASSERT_TRUE(passes());
  ASSERT_TRUE(passes());
  EXPECT_EQ(gaps(), 1U) << "too early, but it came";
}

TEST_F(Watch, WithoutAPeriodASlotIsNotSupervised) {
  admit(watched(0));
  ASSERT_TRUE(passes());
  ASSERT_TRUE(passes());
  EXPECT_EQ(watch().last, 0U);
  EXPECT_EQ(gaps(), 0U);
}

TEST_F(Watch, RestartsWithAnotherPeriod) {
  admit(watched(kPeriod));
  passes_after(3 * kPeriod);
  gates::SlotChanges changes;
  changes.police = {watched(kPeriod / 2)};
  ASSERT_TRUE(gate_.slots().apply(changes));
  EXPECT_EQ(gate_.slots().present().front(), changes.police.front());
  EXPECT_EQ(watch().missing, 0U);
  EXPECT_EQ(gaps(), 0U);
  passes_after(kPeriod);
  EXPECT_EQ(watch().missing, 1U);
}

TEST_F(Watch, EveryEventOfTwoCpusIsCountedOnce) {
  constexpr unsigned frames = 20'000;
  admit(watched(kPeriod));
  const auto send = [&](unsigned cpu) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    ::sched_setaffinity(0, sizeof one, &one);
    for (unsigned i = 0; i < frames; ++i) gate_.run(Direction::ingress, frame(kId, 8));
  };
  std::thread other(send, 1);
  send(0);
  other.join();
  EXPECT_EQ(gaps(), 2 * frames - 1);
  EXPECT_EQ(watch().missing, 0U);
  EXPECT_LT(watch().longest, kSoon);
  EXPECT_GT(watch().shortest, 0U);
}

}  // namespace
}  // namespace mlcca::test
