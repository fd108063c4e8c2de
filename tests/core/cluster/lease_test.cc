// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/lease.hpp"

#include <gtest/gtest.h>

#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {
namespace {

constexpr Value kSecond = 1'000'000'000;

TEST(ClusterLease, TenSecondsLastOneHundredthLessForTheOneAndMoreForTheOther) {
  EXPECT_EQ(valid_until(100 * kSecond, 10 * kSecond), 109'990'000'000U);
  EXPECT_EQ(may_fence_at(100 * kSecond, 10 * kSecond), 111'010'000'000U);
  EXPECT_EQ(queues_empty_at(5 * kSecond), 6'001'000'000U);
}

TEST(ClusterLease, RoundsToTheSafeSide) {
  EXPECT_EQ(valid_until(0, 1001), 999U);
  EXPECT_EQ(may_fence_at(0, 1) - kQueued, 2U);
}

TEST(ClusterLease, DoesNotWrapAround) {
  EXPECT_EQ(may_fence_at(kUnbounded - 1, kMostLease), kUnbounded);
  EXPECT_EQ(valid_until(kUnbounded - 1, kMostLease), kUnbounded);
  EXPECT_EQ(queues_empty_at(kUnbounded - 1), kUnbounded);
}

/// The proof in numbers: the clock of who sends is as slow as it may be, that of who waits as fast.
/// What ends at V on the one has ended, and left its queue, before the other may fence.
TEST(ClusterLease, EndsForTheSenderFirstWhateverTheClocksDo) {
  for (const Value lease : {kLeastLease, 10 * kSecond, kMostLease}) {
    const Value own = valid_until(0, lease);
    const Value real_end = mul_div_up(own, 1'000'000, 1'000'000 - kClockError);
    const Value others = may_fence_at(0, lease);
    const Value real_fence = mul_div_down(others, 1'000'000, 1'000'000 + kClockError);
    EXPECT_LE(real_end, lease);
    EXPECT_GE(real_fence, real_end + mul_div_down(kQueued, 1'000'000, 1'000'000 + kClockError));
  }
}

}  // namespace
}  // namespace mlcca::core::cluster
