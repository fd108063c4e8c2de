// SPDX-License-Identifier: BSD-2-Clause
#include "relay/pace.hpp"

#include <gtest/gtest.h>

namespace mlcca::relay {
namespace {

constexpr std::uint64_t kMs = 1'000'000;

/// Rounds of one ready interface each, evenly spaced. Returns the pause after the last one.
std::uint64_t pause_after(Pace& pace, std::uint64_t from, std::uint64_t gap, unsigned rounds,
                          std::uint64_t shortest = 0) {
  std::uint64_t pause = 0;
  for (unsigned i = 0; i < rounds; ++i) pause = pace.after_round(1, from + i * gap, shortest);
  return pause;
}

TEST(PaceTest, EventsOfOneBusPassWithoutAPause) {
  Pace pace;
  EXPECT_EQ(pause_after(pace, 5 * kMs, 130'000, 1000), 0U);
}

TEST(PaceTest, EventsOfFourBusesAreGathered) {
  Pace pace;
  EXPECT_EQ(pause_after(pace, 5 * kMs, 32'500, 100), Pace::kPause);
}

TEST(PaceTest, ABurstWithinOneWindowIsNotDelayed) {
  Pace pace;
  EXPECT_EQ(pause_after(pace, 5 * kMs, 1'000, 64), 0U);
  EXPECT_EQ(pace.after_round(1, 50 * kMs, 0), 0U);
}

TEST(PaceTest, PausesEndWhenLittleArrives) {
  Pace pace;
  ASSERT_EQ(pause_after(pace, 5 * kMs, 32'500, 100), Pace::kPause);
  std::uint64_t now = 9 * kMs;
  for (int i = 0; i < 70; ++i) EXPECT_EQ(pace.after_round(3, now += 250'000, 0), Pace::kPause);
  EXPECT_EQ(pause_after(pace, now, 150'000, 30), 0U);
}

TEST(PaceTest, PausesEndWithSilence) {
  Pace pace;
  ASSERT_EQ(pause_after(pace, 5 * kMs, 32'500, 100), Pace::kPause);
  EXPECT_EQ(pace.after_round(1, 50 * kMs, 0), 0U);
}

TEST(PaceTest, APauseTakesAtMostAQuarterOfTheShortestLatency) {
  Pace pace;
  EXPECT_EQ(pause_after(pace, 5 * kMs, 32'500, 100, 800'000), 200'000U);
  EXPECT_EQ(pause_after(pace, 9 * kMs, 32'500, 100, 500'000), 125'000U);
  EXPECT_EQ(pause_after(pace, 13 * kMs, 32'500, 100, 1'000), 250U);
}

}  // namespace
}  // namespace mlcca::relay
