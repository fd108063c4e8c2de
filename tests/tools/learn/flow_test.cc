// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using test::kMs;
using test::kSecond;

Flow flow_of(const std::vector<test::Sent>& sent) {
  Flow flow;
  for (const auto& one : sent) flow.add(one.ns, static_cast<std::uint32_t>(one.data.size()));
  return flow;
}

TEST(Flow, KnowsThePeriodTheGapsAndTheLengths) {
  test::Traffic traffic(1);
  const Flow flow = flow_of(traffic.periodic(0, 0x100, 10 * kMs, kMs / 2, 8, 60).sent());
  EXPECT_NEAR(static_cast<double>(flow.events()), 6000, 1);
  EXPECT_NEAR(static_cast<double>(flow.median_gap()), 10e6, 0.2e6);
  EXPECT_GT(flow.regular_share(), 0.99);
  EXPECT_GE(flow.shortest_gap(), 9'500'000U);
  EXPECT_LE(flow.longest_gap(), 10'500'000U);
  EXPECT_EQ(flow.least_bytes(), 8U);
  EXPECT_EQ(flow.most_bytes(), 8U);
}

TEST(Flow, APeriodInWhichSomeEventsAreLostIsStillRegular) {
  test::Traffic traffic(2);
  const Flow flow = flow_of(traffic.periodic(0, 0x100, 10 * kMs, kMs / 2, 8, 60, 20).sent());
  EXPECT_GT(flow.regular_share(), 0.99);
  EXPECT_GT(flow.longest_gap(), 19 * kMs);
}

/// 10 ms with a standard deviation of 0.5 ms is what a program under Linux sends.
TEST(Flow, OrdinaryJitterIsRegularAndTimesAtRandomAreNot) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> late(1e6, 0.5e6);
  std::exponential_distribution<double> apart(1.0);
  Flow ordinary;
  Flow events;
  double at = 0;
  for (std::uint64_t i = 0; i < 6000; ++i) {
    ordinary.add(kSecond + i * 10 * kMs + static_cast<std::uint64_t>(std::max(0.0, late(random))),
                 8);
    events.add(kSecond + static_cast<std::uint64_t>(at += 1e7 * apart(random)), 8);
  }
  EXPECT_GT(ordinary.regular_share(), 0.99);
  EXPECT_LT(events.regular_share(), 0.5);
}

TEST(Flow, BurstsAreNotRegular) {
  test::Traffic traffic(3);
  EXPECT_LT(flow_of(traffic.bursts(0, 0x3e8, 4, kMs / 2, kSecond / 2, 60).sent()).regular_share(),
            0.9);
}

/// What a gate with that period and tolerance would do with the same events.
std::uint64_t refused(const std::vector<test::Sent>& sent, const Rate& rate) {
  std::uint64_t due = 0;
  std::uint64_t count = 0;
  for (const auto& one : sent) {
    if (one.ns + rate.early < due) {
      ++count;
      continue;
    }
    due = std::max(due, one.ns) + rate.period;
  }
  return count;
}

TEST(Flow, APolicerWithAnyOfTheRatesLetsAllOfTheEventsPassAndNoSmallerTolerance) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    test::Traffic traffic(seed);
    if (seed % 2 == 0)
      traffic.periodic(0, 1, (1 + traffic.below(200)) * kMs, traffic.below(3 * kMs), 8, 30,
                       static_cast<unsigned>(traffic.below(50)));
    else
      traffic.bursts(0, 1, 1 + static_cast<unsigned>(traffic.below(8)), kMs / 4, kSecond / 5, 30);
    const auto sent = traffic.sent();
    const Flow flow = flow_of(sent);
    if (flow.events() < Flow::kFirst) continue;
    for (const Rate& rate : flow.rates()) {
      EXPECT_EQ(refused(sent, rate), 0U) << seed;
      if (rate.early != 0) {
        EXPECT_NE(refused(sent, {rate.period, rate.early - 1}), 0U) << seed;
      }
    }
  }
}

TEST(Flow, OfFewEventsNoRateIsKnown) {
  Flow flow;
  for (std::uint64_t i = 0; i + 1 < Flow::kFirst; ++i) flow.add(i * kMs, 1);
  EXPECT_TRUE(flow.rates().empty());
  flow.add(Flow::kFirst * kMs, 1);
  EXPECT_FALSE(flow.rates().empty());
}

TEST(Flow, TimesThatGoBackwardsALittleAreTakenAsTheLatestOne) {
  Flow flow;
  for (std::uint64_t i = 0; i < 100; ++i) flow.add(kSecond + i / 2 * kMs - i % 2 * 1000, 1);
  EXPECT_EQ(flow.shortest_gap(), 0U);
  EXPECT_LE(flow.longest_gap(), kMs);
  EXPECT_EQ(flow.gaps(), 99U);
}

TEST(Flow, WhatIsBetweenTwoStretchesIsNoGap) {
  Flow flow;
  for (std::uint64_t i = 0; i < 100; ++i)
    flow.add(i % 50 * 10 * kMs, 1, {.clock = static_cast<std::uint32_t>(i / 50)});
  EXPECT_EQ(flow.events(), 100U);
  EXPECT_EQ(flow.gaps(), 98U);
  EXPECT_EQ(flow.shortest_gap(), 10 * kMs);
  EXPECT_EQ(flow.longest_gap(), 10 * kMs);
  ASSERT_FALSE(flow.rates().empty());
  EXPECT_EQ(flow.rates().front().period, 10 * kMs);
  EXPECT_EQ(flow.rates().front().early, 0U);
}

TEST(Flow, OfEventsThatAreAloneInTheirStretchesNothingIsKnown) {
  Flow flow;
  for (std::uint32_t i = 0; i < 1000; ++i) flow.add(i * kSecond, 1, {.part = i});
  EXPECT_EQ(flow.gaps(), 0U);
  EXPECT_EQ(flow.mean_of_few(), 0U);
  EXPECT_TRUE(flow.rates().empty());
}

}  // namespace
}  // namespace mlcca::learn
