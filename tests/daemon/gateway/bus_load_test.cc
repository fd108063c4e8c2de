// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/bus_load.hpp"

#include <gtest/gtest.h>

namespace mlcca {
namespace {

constexpr std::uint32_t kBitrate = 111'000;  // a thousand frames of 8 bytes: 47 + 64 bits
constexpr std::uint64_t kSecond = 1'000'000'000;

TEST(BusLoadTest, MoreThanExpectedCountsAtOnceAndLessAfterFiveMeasurements) {
  BusLoad bus;
  EXPECT_EQ(bus.measure({1'000'000, 8'000'000}, kBitrate, 0, kSecond), 0U) << "nothing to compare";
  EXPECT_EQ(bus.measure({1'000'500, 8'004'000}, kBitrate, 300'000, 2 * kSecond), 200'000U);
  EXPECT_EQ(bus.load(), 500'000U);
  for (std::uint64_t second = 3; second < 7; ++second)
    EXPECT_EQ(bus.measure({1'000'500, 8'004'000}, kBitrate, 0, second * kSecond), 200'000U)
        << second;
  EXPECT_EQ(bus.measure({1'000'500, 8'004'000}, kBitrate, 0, 7 * kSecond), 0U);
}

TEST(BusLoadTest, IsRoundedUpToSteps) {
  BusLoad bus;
  bus.measure({0, 0}, kBitrate, 0, kSecond);
  EXPECT_EQ(bus.measure({501, 4008}, kBitrate, 500'000, 2 * kSecond), BusLoad::kStep);
}

TEST(BusLoadTest, IsAnalysedWithTheMostBits) {
  EXPECT_EQ(BusLoad::at_most(0), 0U);
  EXPECT_EQ(BusLoad::at_most(470'000), 800'000U);
  EXPECT_EQ(BusLoad::at_most(900'000), 1'000'000U);
}

TEST(SenderLoadTest, IsTheShareOfItsFramesAndDoesNotSwingByAStep) {
  SenderLoad sender;
  EXPECT_EQ(sender.measure(1000, 8, kBitrate, kSecond), 0U) << "nothing to compare";
  EXPECT_EQ(sender.measure(1500, 8, kBitrate, 2 * kSecond), 500'000U);
  EXPECT_EQ(sender.measure(2001, 8, kBitrate, 3 * kSecond), 500'000U) << "501 frames: one step";
  EXPECT_EQ(sender.measure(2522, 8, kBitrate, 4 * kSecond), 530'000U);
  EXPECT_EQ(sender.measure(2522, 8, kBitrate, 5 * kSecond), 0U) << "no load counts at once";
  EXPECT_EQ(sender.measure(10, 8, kBitrate, 6 * kSecond), 0U) << "a counter that started again";
}

}  // namespace
}  // namespace mlcca
