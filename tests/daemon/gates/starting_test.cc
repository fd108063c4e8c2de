// SPDX-License-Identifier: BSD-2-Clause
// For how long a daemon that starts keeps what the one before it has left.
#include "daemon/gates/starting.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/gates/sandbox.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kLimit = 30 * kSecond;

class StartingTest : public ::testing::Test {
 protected:
  StartingTest() : control_(std::move(*Control::create(test::new_bpf_root()))) { control_.open(); }
  /// A daemon that starts at that time.
  Starting at(std::uint64_t now, std::uint64_t limit = kLimit) {
    auto starting = Starting::begin(control_, limit, now);
    EXPECT_TRUE(starting) << starting.error().text;
    return std::move(*starting);
  }
  Control control_;
};

TEST_F(StartingTest, BeatsUntilItsLimit) {
  auto starting = at(100 * kSecond);
  EXPECT_TRUE(starting.beat(control_, 100 * kSecond));
  EXPECT_TRUE(starting.beat(control_, 130 * kSecond - 1));
  EXPECT_FALSE(starting.beat(control_, 130 * kSecond));
}

TEST_F(StartingTest, BeatsNotAtAllWhereTheLimitIsNothing) {
  EXPECT_FALSE(at(100 * kSecond, 0).beat(control_, 100 * kSecond));
}

TEST_F(StartingTest, OneThatDiedAndOneThatTriesAgainHaveOneLimitTogether) {
  EXPECT_TRUE(at(100 * kSecond).beat(control_, 110 * kSecond));
  EXPECT_TRUE(at(120 * kSecond).beat(control_, 129 * kSecond));
  EXPECT_FALSE(at(120 * kSecond).beat(control_, 130 * kSecond));
  EXPECT_FALSE(at(200 * kSecond).beat(control_, 200 * kSecond));
}

TEST_F(StartingTest, AfterOneThatCameToItsEndTheLimitRestarts) {
  at(100 * kSecond).finish();
  auto next = at(200 * kSecond);
  EXPECT_TRUE(next.beat(control_, 229 * kSecond));
  EXPECT_FALSE(next.beat(control_, 230 * kSecond));
}

TEST_F(StartingTest, GatesThatAreClosedStayWithoutAHeartBeat) {
  auto starting = at(100 * kSecond);
  control_.close_all();
  EXPECT_FALSE(starting.beat(control_, 100 * kSecond));
}

}  // namespace
}  // namespace mlcca::gates
