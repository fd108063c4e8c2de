// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/arrivals.hpp"

#include <gtest/gtest.h>

namespace mlcca::serve {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr Turns::User kAnna{1000, false};
constexpr Turns::User kBert{1001, false};
constexpr Turns::User kMember{1000, true};

TEST(ArrivalsTest, AUserConnectsSoOftenAtOnceAndSoOftenASecond) {
  Arrivals arrivals({10, 10}, {3, 2});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(arrivals.let_in(kAnna, kSecond));
  const auto refused = arrivals.let_in(kAnna, kSecond);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text,
            "you connect too often: one user may do so 3 times at once and 2 times a second");
  EXPECT_TRUE(arrivals.let_in(kAnna, kSecond + kSecond / 2));
  EXPECT_FALSE(arrivals.let_in(kAnna, kSecond + kSecond / 2));
}

TEST(ArrivalsTest, NoUserUsesUpWhatAnotherUserHas) {
  Arrivals arrivals({2, 0}, {1, 0});
  EXPECT_TRUE(arrivals.let_in(kAnna, 0));
  EXPECT_FALSE(arrivals.let_in(kAnna, 0));
  EXPECT_TRUE(arrivals.let_in(kBert, 0));
  EXPECT_TRUE(arrivals.let_in(kMember, 0));
  EXPECT_TRUE(arrivals.let_in(kMember, 0));
  EXPECT_FALSE(arrivals.let_in(kMember, 0));
}

TEST(ArrivalsTest, WhoHasNotConnectedLatelyIsForgotten) {
  Arrivals arrivals({1, 1}, {1, 1});
  EXPECT_TRUE(arrivals.let_in(kAnna, 0));
  EXPECT_TRUE(arrivals.let_in(kBert, 10 * kSecond));
  EXPECT_EQ(arrivals.users(), 1U);
}

}  // namespace
}  // namespace mlcca::serve
