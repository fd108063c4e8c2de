// SPDX-License-Identifier: BSD-2-Clause
// How often the daemon may fork, with a clock that the test makes up.
#include "daemon/gateway/fork_budget.hpp"

#include <gtest/gtest.h>

namespace mlcca {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kMilli = 1'000'000;
constexpr serve::Turns::User kAnna{.uid = 1000, .member = false};
constexpr serve::Turns::User kBert{.uid = 1001, .member = false};
constexpr serve::Turns::User kRoot{.uid = 0, .member = true};

TEST(ForkBudgetTest, AUserHasFourAtOnceAndThenTwoASecond) {
  ForkBudget budget(ForkBudget::kUsual);
  std::uint64_t now = kSecond;
  for (int i = 0; i < 4; ++i) {
    EXPECT_LE(budget.ready_at(kAnna, now), now);
    budget.forked(kAnna, now, now);
  }
  EXPECT_EQ(budget.ready_at(kAnna, now), now + kSecond / 2);
  EXPECT_LE(budget.ready_at(kBert, now), now) << "it is hers alone";
  now += kSecond / 2;
  EXPECT_LE(budget.ready_at(kAnna, now), now);
  budget.forked(kAnna, now, now);
  EXPECT_EQ(budget.ready_at(kAnna, now), now + kSecond / 2);
}

TEST(ForkBudgetTest, AMemberHasMore) {
  ForkBudget budget(ForkBudget::kUsual);
  for (int i = 0; i < 20; ++i) budget.forked(kRoot, 0, 0);
  EXPECT_EQ(budget.ready_at(kRoot, 0), kSecond / 10);
}

TEST(ForkBudgetTest, NoUserOfThatGroupForksForTwentyTimesAsLongAsTheLastForkTook) {
  ForkBudget budget(ForkBudget::kUsual);
  budget.forked(kAnna, 0, 40 * kMilli);
  EXPECT_EQ(budget.ready_at(kBert, 40 * kMilli), 840 * kMilli);
  budget.forked(kBert, 840 * kMilli, 841 * kMilli);
  EXPECT_EQ(budget.ready_at(kAnna, 841 * kMilli), 861 * kMilli);
}

TEST(ForkBudgetTest, AForkForOneWithoutRightsMakesNoMemberWaitNorTheOtherWayRound) {
  ForkBudget budget(ForkBudget::kUsual);
  budget.forked(kAnna, 0, 40 * kMilli);
  EXPECT_EQ(budget.ready_at(kRoot, 40 * kMilli), 40 * kMilli);
  budget.forked(kRoot, 40 * kMilli, 80 * kMilli);
  EXPECT_EQ(budget.ready_at(kRoot, 80 * kMilli), 880 * kMilli);
  EXPECT_EQ(budget.ready_at(kBert, 80 * kMilli), 840 * kMilli);
}

TEST(ForkBudgetTest, ADaemonThatWasStoppedInAForkForksAgainWithinTenSeconds) {
  ForkBudget budget(ForkBudget::kUsual);
  const std::uint64_t hours = 3600 * kSecond;
  budget.forked(kAnna, 0, hours);
  EXPECT_EQ(budget.ready_at(kBert, hours), hours + 10 * kSecond);
}

TEST(ForkBudgetTest, WhoHasNotForkedLatelyIsForgotten) {
  ForkBudget budget(ForkBudget::kUsual);
  budget.forked(kAnna, 0, 0);
  budget.tidy(kMilli);
  EXPECT_EQ(budget.users(), 1U);
  budget.tidy(2 * kSecond);
  EXPECT_EQ(budget.users(), 0U);
}

}  // namespace
}  // namespace mlcca
