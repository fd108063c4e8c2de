// SPDX-License-Identifier: BSD-2-Clause
#include "base/outage.hpp"

#include <gtest/gtest.h>

namespace mlcca {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
using Report = Outage::Report;

TEST(OutageTest, LossAndReturnAreReportedOnceEach) {
  Outage outage;
  EXPECT_EQ(outage.take(false, 0), Report::none);
  EXPECT_EQ(outage.take(true, kSecond), Report::lost);
  for (std::uint64_t s = 2; s < 100; ++s) EXPECT_EQ(outage.take(true, s * kSecond), Report::none);
  EXPECT_EQ(outage.take(false, 100 * kSecond), Report::back);
  EXPECT_EQ(outage.take(false, 101 * kSecond), Report::none);
}

TEST(OutageTest, WhatComesAndGoesIsReportedEachTenSecondsAndCounted) {
  Outage outage;
  unsigned reports = 0;
  for (std::uint64_t ms = 0; ms < 100'000; ms += 100)
    if (outage.take(ms % 200 == 0, ms * (kSecond / 1000)) == Report::lost) ++reports;
  EXPECT_EQ(reports, 10U);
  EXPECT_EQ(outage.take_unreported(), 490U);
  EXPECT_EQ(outage.take_unreported(), 0U);
}

TEST(OutageTest, ALossThatLastsIsReportedWhenItMayBe) {
  Outage outage;
  EXPECT_EQ(outage.take(true, 0), Report::lost);
  EXPECT_EQ(outage.take(false, kSecond), Report::back);
  EXPECT_EQ(outage.take(true, 2 * kSecond), Report::none);
  EXPECT_EQ(outage.take(true, 9 * kSecond), Report::none);
  EXPECT_EQ(outage.take(true, 10 * kSecond), Report::lost);
  EXPECT_EQ(outage.take(false, 11 * kSecond), Report::back);
}

}  // namespace
}  // namespace mlcca
