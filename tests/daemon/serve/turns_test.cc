// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/turns.hpp"

#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace mlcca::serve {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr Rate kPlenty{1'000'000, 1'000'000};
constexpr Turns::User kMember{1000, true};
constexpr Turns::User kOne{65534, false};
constexpr Turns::User kOther{65533, false};

TEST(BucketTest, HoldsABurstAndFillsWithTime) {
  Bucket bucket({3, 10}, kSecond);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(bucket.take(kSecond));
  EXPECT_FALSE(bucket.take(kSecond));
  EXPECT_EQ(bucket.ready_at(kSecond), kSecond + kSecond / 10);
  EXPECT_FALSE(bucket.take(kSecond + kSecond / 10 - 1));
  EXPECT_TRUE(bucket.take(kSecond + kSecond / 10));
}

TEST(BucketTest, HoldsNoMoreThanABurstHoweverMuchTimePasses) {
  Bucket bucket({3, 10}, 0);
  EXPECT_TRUE(bucket.take(0));
  EXPECT_FALSE(bucket.full(kSecond / 10 - 1));
  EXPECT_TRUE(bucket.full(kSecond / 10));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(bucket.take(~0ULL - 1));
  EXPECT_FALSE(bucket.take(~0ULL - 1));
}

TEST(BucketTest, DoesNotMindAClockThatStands) {
  Bucket bucket({1, 1}, 5 * kSecond);
  EXPECT_TRUE(bucket.take(4 * kSecond));
  EXPECT_FALSE(bucket.take(4 * kSecond));
}

TEST(TurnsTest, FiftySessionsOfOneUserGetNoMoreThanOneOfAnother) {
  Turns turns(kPlenty, kPlenty);
  std::map<Turns::Id, int> served;
  for (int s = 0; s < 50; ++s) turns.add(kOne, s);
  turns.add(kOther, 99);
  for (int i = 0; i < 200; ++i) {
    const auto next = turns.next(0);
    ASSERT_TRUE(next);
    ++served[*next];
    turns.add(*next == 99 ? kOther : kOne, *next);
  }
  EXPECT_EQ(served[99], 100);
  for (int s = 0; s < 50; ++s) EXPECT_EQ(served[s], 2) << s;
}

TEST(TurnsTest, MembersHaveEverySecondTurn) {
  Turns turns(kPlenty, kPlenty);
  turns.add(kOne, 1);
  turns.add(kOther, 2);
  turns.add(kMember, 3);
  int member = 0;
  for (int i = 0; i < 100; ++i) {
    const auto next = turns.next(0);
    ASSERT_TRUE(next);
    if (*next == 3) ++member;
    turns.add(*next == 3 ? kMember : *next == 1 ? kOne : kOther, *next);
  }
  EXPECT_EQ(member, 50);
}

TEST(TurnsTest, OnlyAUserThatHasUsedItsRateWaits) {
  Turns turns(kPlenty, {2, 1});
  turns.add(kOne, 1);
  EXPECT_EQ(turns.next(0), 1);
  EXPECT_TRUE(turns.step(kOne, 0));
  EXPECT_FALSE(turns.step(kOne, 0));
  turns.add(kOne, 1);
  EXPECT_EQ(turns.next(0), std::nullopt);
  EXPECT_FALSE(turns.empty());
  EXPECT_EQ(turns.next_ready(0), kSecond);
  turns.add(kOther, 2);
  EXPECT_EQ(turns.next_ready(0), 0U);
  EXPECT_EQ(turns.next(0), 2);
  EXPECT_EQ(turns.next(kSecond), 1);
  EXPECT_TRUE(turns.empty());
  EXPECT_EQ(turns.next_ready(kSecond), std::nullopt);
}

TEST(TurnsTest, ComingAgainDoesNotFillTheBucket) {
  Turns turns(kPlenty, {1, 1});
  turns.add(kOne, 1);
  EXPECT_EQ(turns.next(kSecond), 1);
  turns.tidy(kSecond);
  EXPECT_EQ(turns.users(), 1U);
  turns.add(kOne, 2);
  EXPECT_EQ(turns.next(kSecond), std::nullopt);
  turns.remove(kOne, 2);
  EXPECT_TRUE(turns.empty());
  turns.tidy(3 * kSecond);
  EXPECT_EQ(turns.users(), 0U);
}

TEST(TurnsTest, ASessionThatEndsIsNotServed) {
  Turns turns(kPlenty, kPlenty);
  turns.add(kOne, 1);
  turns.add(kOne, 2);
  turns.remove(kOne, 1);
  turns.remove(kOther, 7);
  EXPECT_EQ(turns.next(0), 2);
  EXPECT_EQ(turns.next(0), std::nullopt);
}

}  // namespace
}  // namespace mlcca::serve
