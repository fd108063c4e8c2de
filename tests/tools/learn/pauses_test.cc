// SPDX-License-Identifier: BSD-2-Clause
// Cyclic messages that pause, because the ignition or a machine is off for a while: they have their
// cycle, and the pauses are said. Silence between bursts is no pause.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using test::drafted;
using test::Gate;
using test::kMs;
using test::kSecond;
using test::Sent;

constexpr std::uint32_t kPausing = 0x200;

/// A pause behind so many cycles.
struct Pause {
  std::uint64_t after = 0;
  std::uint64_t ns = 0;
};

/// `cycles` of one identifier with these pauses, while another one is sent each 20 ms.
std::vector<Sent> with_pauses(std::uint64_t period, std::uint64_t jitter, std::uint64_t cycles,
                              const std::vector<Pause>& pauses, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::vector<Sent> out;
  std::uint64_t at = kSecond;
  for (std::uint64_t i = 0; i < cycles; ++i) {
    for (const Pause& pause : pauses)
      if (pause.after == i) at += pause.ns;
    out.push_back(
        {.ns = at + (jitter == 0 ? 0 : random() % jitter), .id = kPausing, .data = {1, 2}});
    at += period;
  }
  const std::uint64_t end = at;
  for (std::uint64_t ns = kSecond; ns < end; ns += 20 * kMs)
    out.push_back({.ns = ns + kMs, .id = 0x100, .data = {1}});
  return test::in_order(std::move(out));
}

const DraftChannel& pausing_in(const Draft& draft) {
  const auto found = std::ranges::find(draft.channels, "can0-200", &DraftChannel::name);
  EXPECT_NE(found, draft.channels.end());
  return found == draft.channels.end() ? draft.channels.front() : *found;
}

bool says(const Draft& draft, std::string_view text) {
  return std::ranges::any_of(draft.left_out,
                             [&](const std::string& line) { return line.contains(text); });
}

/// What was learned passes, and so does the same again, half a minute later.
void expect_all_passes(const Draft& draft, const std::vector<Sent>& sent, const std::string& what) {
  Gate gate(draft);
  std::size_t dropped = 0;
  for (const Sent& one : sent) dropped += gate.passes(one) ? 0 : 1;
  const std::uint64_t later = sent.back().ns + 30 * kSecond;
  for (Sent one : sent) {
    one.ns += later;
    dropped += gate.passes(one) ? 0 : 1;
  }
  EXPECT_EQ(dropped, 0U) << what << '\n' << draft.xml;
}

TEST(Pauses, OfACycleLeaveItItsPeriodWhereverTheyAre) {
  for (const std::uint64_t after : {1U, 5U, 20U, 31U, 40U, 300U, 590U}) {
    const auto sent = with_pauses(100 * kMs, kMs, 600, {{after, 10 * kSecond}});
    const Draft draft = drafted(sent, {}, {"can0"});
    const DraftChannel& is = pausing_in(draft);
    EXPECT_TRUE(is.periodic) << after << draft.xml;
    EXPECT_EQ(is.period, 100 * kMs) << after;
    EXPECT_EQ(is.omission, 1U) << after;
    EXPECT_LE(is.jitter, 2 * kMs) << after;
    expect_all_passes(draft, sent, std::to_string(after));
  }
}

TEST(Pauses, OfTwoKindsWhileTheIgnitionIsOffDropNothingAfterwards) {
  const auto sent =
      with_pauses(10 * kMs, kMs, 3000, {{3, 10 * kSecond}, {11, 8 * kSecond}, {900, kSecond}});
  const Draft draft = drafted(sent, {}, {"can0"});
  EXPECT_EQ(pausing_in(draft).period, 10 * kMs);
  EXPECT_TRUE(pausing_in(draft).periodic);
  expect_all_passes(draft, sent, "ignition");
}

TEST(Pauses, AreCountedAndSaidAndReportedByTheGate) {
  const auto sent = with_pauses(100 * kMs, kMs, 600, {{100, 10 * kSecond}, {300, 4 * kSecond}});
  const Draft draft = drafted(sent, {}, {"can0"});
  const DraftChannel& is = pausing_in(draft);
  EXPECT_EQ(is.gaps.pauses, 2U);
  EXPECT_NEAR(static_cast<double>(is.gaps.longest_pause), 10.1e9, 2e6);
  EXPECT_EQ(is.gaps.longest, is.gaps.longest_pause);
  EXPECT_TRUE(draft.xml.contains("2 pauses, the longest of 10.1s, are no part of its cycle"))
      << draft.xml;
  EXPECT_TRUE(says(draft,
                   "can0: 0x200 paused while others went on: the draft has its cycle, so "
                   "its subscribers get an exception when it pauses"))
      << draft.left_out.size();
  Gate gate(draft);
  for (const Sent& one : sent) gate.passes(one);
  EXPECT_EQ(gate.silences(), 2U);
}

TEST(Pauses, OfCyclesWithoutAnyNothingIsSaid) {
  const Draft draft = drafted(with_pauses(100 * kMs, kMs, 600, {}), {}, {"can0"});
  EXPECT_EQ(pausing_in(draft).gaps.pauses, 0U);
  EXPECT_EQ(pausing_in(draft).gaps.longest_pause, 0U);
  EXPECT_FALSE(draft.xml.contains("pause")) << draft.xml;
  EXPECT_FALSE(says(draft, "paused"));
}

/// A gap of ten cycles may be due to lost events; a longer one is a pause.
TEST(Pauses, AreLongerThanWhatMayBeLost) {
  for (const std::uint64_t lost : {8U, 12U}) {
    const auto sent = with_pauses(100 * kMs, 0, 600, {{200, lost * 100 * kMs}});
    const Draft draft = drafted(sent, {}, {"can0"});
    EXPECT_TRUE(pausing_in(draft).periodic) << draft.xml;
    EXPECT_EQ(pausing_in(draft).gaps.pauses, lost > 10 ? 1U : 0U) << lost;
    EXPECT_EQ(pausing_in(draft).omission, lost > 10 ? 1U : lost + 1) << lost;
  }
}

TEST(Pauses, WhatWasLostIsStillAnOmission) {
  const auto sent =
      with_pauses(100 * kMs, 0, 600, {{200, 10 * kSecond}, {300, 500 * kMs}, {400, 200 * kMs}});
  EXPECT_EQ(pausing_in(drafted(sent, {}, {"can0"})).omission, 6U);
}

/// Runs of so many cycles, so far apart, with pauses of 2 s between them.
std::vector<Sent> runs(std::uint64_t cycles, std::uint64_t period) {
  std::vector<Pause> pauses;
  for (std::uint64_t i = 1; i < 20; ++i) pauses.push_back({i * cycles, 2 * kSecond});
  return with_pauses(period, 0, 20 * cycles, pauses);
}

TEST(Pauses, AreNotTheSilenceBetweenBursts) {
  struct Case {
    std::uint64_t cycles;
    std::uint64_t period;
    bool periodic;
  };
  for (const Case& c : {Case{20, 100 * kMs, true}, Case{14, 100 * kMs, false},
                        Case{60, 10 * kMs, true}, Case{40, 10 * kMs, false}}) {
    const auto sent = runs(c.cycles, c.period);
    const Draft draft = drafted(sent, {}, {"can0"});
    EXPECT_EQ(pausing_in(draft).periodic, c.periodic) << c.cycles << ' ' << c.period;
    EXPECT_EQ(pausing_in(draft).gaps.pauses, c.periodic ? 19U : 0U) << c.cycles << ' ' << c.period;
    expect_all_passes(draft, sent, std::to_string(c.cycles));
  }
}

TEST(Pauses, OfAFewCyclesDoNotMakeTheirPeriodLonger) {
  const auto sent = with_pauses(200 * kMs, 0, 24, {{10, 10 * kSecond}});
  const Draft draft = drafted(sent, {}, {"can0"});
  EXPECT_EQ(pausing_in(draft).period, 100 * kMs) << "half the mean, as of few events";
  EXPECT_EQ(pausing_in(draft).gaps.pauses, 1U);
  EXPECT_TRUE(draft.xml.contains("every 200ms without 1 pause of 10.2s")) << draft.xml;
  Gate gate(draft);
  for (std::uint64_t i = 0; i < 1000; ++i)
    EXPECT_TRUE(gate.passes({.ns = kSecond + i * 200 * kMs, .id = kPausing, .data = {1, 2}}));
}

TEST(Pauses, WhateverTheyAreNothingIsDroppedAndOnlyTheyAreReported) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 random(seed);
    const std::uint64_t period = (10 + random() % 200) * kMs;
    const std::uint64_t jitter = random() % (period / 5);
    const std::uint64_t cycles = 1000 + random() % 1000;
    std::vector<Pause> pauses;
    for (std::uint64_t i = 1 + random() % 4; i > 0; --i)
      pauses.push_back({i * 200 + random() % 100, period * (12 + random() % 100)});
    const auto sent = with_pauses(period, jitter, cycles, pauses, seed);
    const Draft draft = drafted(sent, {}, {"can0"});
    const std::string what = "seed " + std::to_string(seed);
    EXPECT_TRUE(pausing_in(draft).periodic) << what << draft.xml;
    EXPECT_EQ(pausing_in(draft).gaps.pauses, pauses.size()) << what;
    EXPECT_GE(pausing_in(draft).period, period * 7 / 10) << what;
    expect_all_passes(draft, sent, what);
    Gate gate(draft);
    for (const Sent& one : sent) gate.passes(one);
    EXPECT_EQ(gate.silences(), pauses.size()) << what << draft.xml;
  }
}

}  // namespace
}  // namespace mlcca::learn
