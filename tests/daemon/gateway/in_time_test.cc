// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/in_time.hpp"

#include <gtest/gtest.h>

#include <latch>
#include <memory>
#include <string>

namespace mlcca {
namespace {

constexpr std::uint64_t kLong = 600'000'000'000;  // ns
constexpr std::uint64_t kShort = 1'000'000;       // ns

TEST(InTime, GivesWhatTheWorkGives) {
  const auto given = in_time([] { return std::string("done"); }, kLong, [] {});
  EXPECT_EQ(given, "done");
}

TEST(InTime, DoesSomethingElseMeanwhile) {
  const auto goes_on = std::make_shared<std::latch>(1);
  int meanwhile = 0;
  const auto given = in_time(
      [goes_on] {
        goes_on->wait();
        return 5;
      },
      kLong,
      [&] {
        if (++meanwhile == 3) goes_on->count_down();
      });
  EXPECT_EQ(given, 5);
  EXPECT_GE(meanwhile, 3);
}

TEST(InTime, WhatHangsIsGivenUpAndGoesOnAlone) {
  const auto goes_on = std::make_shared<std::latch>(1);
  const auto has_ended = std::make_shared<std::latch>(1);
  const auto given = in_time(
      [goes_on, has_ended] {
        goes_on->wait();
        has_ended->count_down();
        return 5;
      },
      kShort, [] {});
  EXPECT_EQ(given, std::nullopt);
  goes_on->count_down();
  has_ended->wait();
}

}  // namespace
}  // namespace mlcca
