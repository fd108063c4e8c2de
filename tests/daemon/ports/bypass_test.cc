// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/bypass.hpp"

#include <gtest/gtest.h>

namespace mlcca {
namespace {

Bypass::Counts counts(std::uint64_t let_out, std::uint64_t sent, std::uint64_t waiting = 0) {
  return {.let_out_before = let_out, .waiting = waiting, .sent = sent, .let_out_after = let_out};
}

TEST(BypassTest, FramesSentBeforeTheFirstUpdateAreNotReported) {
  Bypass bypass;
  EXPECT_EQ(bypass.update(counts(0, 5000)), 0U);
  EXPECT_EQ(bypass.update(counts(100, 5100)), 0U);
}

TEST(BypassTest, MoreThanADriverHoldsIsReported) {
  Bypass bypass;
  bypass.update(counts(0, 0));
  EXPECT_EQ(bypass.update(counts(10, 10 + Bypass::kInDriver)), 0U);
  EXPECT_EQ(bypass.update(counts(20, 20 + Bypass::kInDriver + 1)), Bypass::kInDriver + 1);
  EXPECT_EQ(bypass.update(counts(30, 30 + Bypass::kInDriver + 1)), 0U) << "reported once";
}

TEST(BypassTest, SlowBypassIsFoundInTheEnd) {
  Bypass bypass;
  bypass.update(counts(0, 0));
  std::uint64_t found = 0;
  for (std::uint64_t second = 1; second <= Bypass::kInDriver + 1; ++second)
    found += bypass.update(counts(1000 * second, 1001 * second));
  EXPECT_EQ(found, Bypass::kInDriver + 1);
}

TEST(BypassTest, QueueThatFillsAndEmptiesIsNoBypass) {
  Bypass bypass;
  bypass.update(counts(1000, 0, 1000));
  EXPECT_EQ(bypass.update(counts(1000, 1000, 0)), 0U);
  EXPECT_EQ(bypass.update(counts(3000, 1500, 1500)), 0U);
  EXPECT_EQ(bypass.update(counts(3000, 3000, 0)), 0U);
}

TEST(BypassTest, FramesInTheDriverAreNoBypass) {
  Bypass bypass;
  bypass.update(counts(0, 0));
  EXPECT_EQ(bypass.update(counts(Bypass::kInDriver, 0)), 0U);
  EXPECT_EQ(bypass.update(counts(Bypass::kInDriver, Bypass::kInDriver)), 0U);
}

TEST(BypassTest, LostFramesOfTheGateDoNotHideThoseThatWentPastLater) {
  Bypass bypass;
  bypass.update(counts(0, 0));
  EXPECT_EQ(bypass.update(counts(500, 0)), 0U);
  EXPECT_EQ(bypass.update(counts(500, 100)), 100U);
}

TEST(BypassTest, FramesBetweenTheReadingsAreNoBypass) {
  Bypass bypass;
  const auto update = [&](std::uint64_t before, std::uint64_t sent, std::uint64_t after) {
    return bypass.update(
        {.let_out_before = before, .waiting = 0, .sent = sent, .let_out_after = after});
  };
  update(0, 500, 1000);
  EXPECT_EQ(update(100'000, 100'900, 101'000), 0U);
  EXPECT_EQ(update(200'000, 200'100, 201'000), 0U);
}

TEST(BypassTest, CountersThatWereSetBackStartAgain) {
  Bypass bypass;
  bypass.update(counts(5000, 5000));
  EXPECT_EQ(bypass.update(counts(0, 5000)), 0U) << "another gate";
  EXPECT_EQ(bypass.update(counts(0, 0)), 0U) << "another device";
  EXPECT_EQ(bypass.update(counts(0, 100)), 100U);
}

TEST(BypassTest, ForgottenIsAsNew) {
  Bypass bypass;
  bypass.update(counts(0, 0));
  bypass.forget();
  EXPECT_EQ(bypass.update(counts(0, 1000)), 0U);
}

}  // namespace
}  // namespace mlcca
