// SPDX-License-Identifier: BSD-2-Clause
// Events that come at random: a gate that holds what is drafted of the first half of a recording
// passes the second half.
#include "tools/learn/arrivals.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tools/learn/channels.hpp"

namespace mlcca::learn {
namespace {

using test::kMs;
using test::kSecond;
using test::Sent;

/// Times of so many events, in seconds.
using Process = std::function<std::vector<double>(std::mt19937_64&, std::size_t)>;

double apart(std::mt19937_64& random, double mean) {
  return std::exponential_distribution<double>(1 / mean)(random);
}

std::vector<double> poisson(std::mt19937_64& random, std::size_t count) {
  std::vector<double> out;
  for (double at = 0; out.size() < count;) out.push_back(at += apart(random, 0.05));
  return out;
}

/// Bursts of 1 to 10 frames, 1 s apart in the mean.
std::vector<double> bursts(std::mt19937_64& random, std::size_t count) {
  std::vector<double> out;
  for (double at = 0; out.size() < count;) {
    at += apart(random, 1);
    for (auto n = 1 + random() % 10; n > 0; --n) out.push_back(at += 0.0003);
  }
  return out;
}

/// Events every 20 ms in the mean for about a second, then none for about 5 s.
std::vector<double> on_and_off(std::mt19937_64& random, std::size_t count) {
  std::vector<double> out;
  for (double at = 0; out.size() < count;) {
    const double end = at + apart(random, 1);
    for (at += apart(random, 0.02); at < end; at += apart(random, 0.02)) out.push_back(at);
    at = end + apart(random, 5);
  }
  return out;
}

/// The rate goes up and down by a fifth, 1.5 times in all.
std::vector<double> drifting(std::mt19937_64& random, std::size_t count) {
  std::vector<double> out;
  for (double at = 0; out.size() < count;) {
    const double part = static_cast<double>(out.size()) / static_cast<double>(count);
    out.push_back(at += apart(random, 0.05 / (1 + 0.2 * std::sin(3 * std::numbers::pi * part))));
  }
  return out;
}

struct Kind {
  const char* name;
  Process process;
};

class ArrivalsTest : public ::testing::TestWithParam<Kind> {};

TEST_P(ArrivalsTest, OfTheSecondHalfLessThanOneOfAThousandIsDropped) {
  test::Share all;
  double periods = 0;
  std::uint64_t drafts = 0;
  for (const std::size_t count : {200U, 400U, 1200U, 4000U})
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      std::mt19937_64 random(seed * 1000 + count);
      std::vector<Sent> sent;
      for (const double at : GetParam().process(random, count))
        sent.push_back({.ns = kSecond + static_cast<std::uint64_t>(at * 1e9),
                        .id = 0x345,
                        .data = {static_cast<std::uint8_t>(random())}});
      const std::uint64_t middle = sent[count / 2].ns;
      const Draft draft = test::drafted(test::before(sent, middle), {}, {"can0"});
      ASSERT_EQ(draft.channels.size(), 1U);
      EXPECT_FALSE(draft.channels[0].periodic) << draft.xml;
      EXPECT_TRUE(draft.xml.contains("arrival=\"sporadic\"")) << draft.xml;
      EXPECT_EQ(test::refused_in(draft), 0U) << draft.xml;
      test::Gate gate(draft);
      const auto dropped = test::from(sent, middle, gate, [](const Sent&) { return true; });
      EXPECT_LT(dropped.frames * 40, dropped.of) << count << ", seed " << seed << draft.xml;
      all += dropped;
      periods += static_cast<double>(draft.channels[0].period) * static_cast<double>(count / 2) /
                 static_cast<double>(middle - kSecond);
      ++drafts;
    }
  std::printf("%s: %llu of %llu dropped; the Period is %.2f of the mean gap\n", GetParam().name,
              static_cast<unsigned long long>(all.frames), static_cast<unsigned long long>(all.of),
              periods / static_cast<double>(drafts));
  EXPECT_LT(all.frames * 1000, all.of);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ArrivalsTest,
                         ::testing::Values(Kind{"Poisson", poisson}, Kind{"Bursts", bursts},
                                           Kind{"OnAndOff", on_and_off},
                                           Kind{"Drifting", drifting}),
                         [](const auto& kind) { return std::string(kind.param.name); });

// --- the figures ---------------------------------------------------------------------------------

Flow flow_of(const std::vector<double>& times) {
  Flow flow;
  for (const double at : times) flow.add(kSecond + static_cast<std::uint64_t>(at * 1e9), 1);
  return flow;
}

TEST(Arrivals, ThePeriodStaysBelowTheMeanByWhatTheMeanMayBeWrongBy) {
  for (const std::size_t count : {101U, 1001U, 10001U}) {
    std::mt19937_64 random(count);
    const Flow flow = flow_of(poisson(random, count));
    const double mean = static_cast<double>(flow.active()) / static_cast<double>(flow.gaps());
    const double expected = 0.75 * (1 - 2 / std::sqrt(static_cast<double>(count - 1)));
    EXPECT_NEAR(static_cast<double>(longest_period(flow)) / mean, expected, 0.03) << count;
  }
  std::mt19937_64 random(1);
  const Flow wild = flow_of(on_and_off(random, 40));
  EXPECT_GT(longest_period(wild), 0U);
}

/// For a Poisson process of rate r, e^(tP) = 1 + t/r: of r = 20/s and P = 25 ms, t is 50.3/s.
TEST(Arrivals, TheJitterIsThatOfAQueueThatServesOneEventInAPeriod) {
  std::mt19937_64 random(7);
  const Flow flow = flow_of(poisson(random, 20'000));
  const double expected = std::log(static_cast<double>(kOneOf)) / 50.3;
  EXPECT_NEAR(static_cast<double>(jitter_of_queue(flow, 25 * kMs)) / 1e9, expected,
              expected * 0.06);
}

TEST(Arrivals, WhatNeverWaitsNeedsNoJitterAndWhatOverrunsHasNone) {
  Flow cycle;
  for (std::uint64_t i = 0; i < 100; ++i) cycle.add(kSecond + i * 10 * kMs, 1);
  EXPECT_EQ(jitter_of_queue(cycle, 5 * kMs), 0U);
  EXPECT_EQ(jitter_of_queue(cycle, 20 * kMs), UINT64_MAX);
}

}  // namespace
}  // namespace mlcca::learn
