// SPDX-License-Identifier: BSD-2-Clause
// Messages with a cycle, and those that come on events in between, too: what is drafted of them
// drops nothing of what was learned, and misses nothing of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tools/learn/channels.hpp"

namespace mlcca::learn {
namespace {

using test::drafted;
using test::Gate;
using test::kMs;
using test::kSecond;
using test::Sent;

/// `count` cycles and `events` in between, at random times.
std::vector<Sent> mixed(std::mt19937_64& random, std::uint64_t period, std::uint64_t jitter,
                        std::uint64_t count, std::uint64_t events) {
  std::vector<Sent> out;
  out.reserve(count + events);
  for (std::uint64_t i = 0; i < count; ++i)
    out.push_back({.ns = kSecond + i * period + (jitter == 0 ? 0 : random() % jitter),
                   .id = 0x201,
                   .data = {1}});
  for (std::uint64_t i = 0; i < events; ++i)
    out.push_back({.ns = kSecond + random() % (count * period), .id = 0x201, .data = {1}});
  std::ranges::sort(out, {}, &Sent::ns);
  return out;
}

void expect_nothing_wrong(const Draft& draft, const std::vector<Sent>& sent,
                          const std::string& what) {
  Gate gate(draft);
  std::size_t dropped = 0;
  for (const Sent& one : sent) dropped += gate.passes(one) ? 0 : 1;
  EXPECT_EQ(dropped, 0U) << what << draft.xml;
  EXPECT_EQ(gate.missing(), 0U) << what << draft.xml;
  EXPECT_EQ(gate.silences(), 0U) << what << draft.xml;
}

TEST(Cycle, AFewEventsInBetweenLeaveItsPeriodAboutWhatItIs) {
  std::mt19937_64 random(4);
  for (const std::uint64_t events : {1U, 5U, 30U, 300U}) {
    const auto sent = mixed(random, 100 * kMs, 0, 6000, events);
    const Draft draft = drafted(sent, {}, {"can0"});
    ASSERT_EQ(draft.channels.size(), 1U);
    const DraftChannel& is = draft.channels[0];
    EXPECT_TRUE(is.periodic) << events;
    EXPECT_TRUE(is.on_events) << events;
    EXPECT_GE(is.period, 75 * kMs) << events;
    EXPECT_LE(is.period, 100 * kMs) << events;
    EXPECT_TRUE(draft.xml.contains("cyclic and on events")) << draft.xml;
    EXPECT_EQ(test::refused_in(draft), 0U);
    expect_nothing_wrong(draft, sent, std::to_string(events));
  }
}

TEST(Cycle, WithoutEventsInBetweenItIsOnlyPeriodic) {
  std::mt19937_64 random(5);
  const Draft draft = drafted(mixed(random, 10 * kMs, kMs, 6000, 0), {}, {"can0"});
  EXPECT_TRUE(draft.channels.at(0).periodic);
  EXPECT_FALSE(draft.channels.at(0).on_events);
  EXPECT_EQ(draft.channels.at(0).period, 10 * kMs);
}

TEST(Cycle, WhateverTheMixNothingThatWasLearnedIsDroppedOrMissing) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 random(seed);
    const std::uint64_t period = (1 + random() % 200) * kMs;
    const std::uint64_t jitter = random() % (period / 5);
    const std::uint64_t count = 40 + random() % 4000;
    const std::uint64_t events = random() % (count / 25 + 1);
    const auto sent = mixed(random, period, jitter, count, events);
    const std::string what = "seed " + std::to_string(seed) + ", " + std::to_string(events) +
                             " of " + std::to_string(count) + " every " + std::to_string(period) +
                             " + " + std::to_string(jitter) + "\n";
    const Draft draft = drafted(sent, {}, {"can0"});
    const DraftChannel& is = draft.channels.at(0);
    EXPECT_TRUE(is.periodic) << what << draft.xml;
    EXPECT_GE(is.period, period * 7 / 10) << what;
    expect_nothing_wrong(draft, sent, what);
  }
}

/// What was lost is missing, and no silence.
TEST(Cycle, TheOmissionCountsInThePeriodThatIsStated) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    auto sent = mixed(random, 50 * kMs, 5 * kMs, 2000, 20);
    std::erase_if(sent, [&](const Sent&) { return random() % 50 == 0; });
    const Draft draft = drafted(sent, {}, {"can0"});
    EXPECT_TRUE(draft.channels.at(0).periodic) << draft.xml;
    Gate gate(draft);
    for (const Sent& one : sent) EXPECT_TRUE(gate.passes(one)) << draft.xml;
    EXPECT_GT(gate.missing(), 0U);
    EXPECT_EQ(gate.silences(), 0U) << draft.xml;
  }
}

TEST(Cycle, EventsAtRandomHaveNone) {
  std::mt19937_64 random(6);
  std::exponential_distribution<double> apart(1.0);
  std::vector<Sent> sent;
  sent.reserve(2000);
  double at = 1e9;
  for (int i = 0; i < 2000; ++i)
    sent.push_back(
        {.ns = static_cast<std::uint64_t>(at += 5e7 * apart(random)), .id = 0x201, .data = {1}});
  const Draft draft = drafted(sent, {}, {"can0"});
  EXPECT_FALSE(draft.channels.at(0).periodic) << draft.xml;
}

/// Every `period`, late by up to a twenty-fifth of it; one in `lost` does not come, 0: all come.
std::vector<Sent> cycle_of(std::uint64_t period, std::uint64_t count, std::uint64_t seed,
                           std::uint64_t lost = 0) {
  std::mt19937_64 random(seed);
  std::vector<Sent> out;
  for (std::uint64_t i = 0; i < count; ++i)
    if (const std::uint64_t late = random() % (period / 25); lost == 0 || i % lost != lost - 1)
      out.push_back(
          {.ns = kSecond + i * period + late, .id = 0x201, .data = {static_cast<std::uint8_t>(i)}});
  return out;
}

TEST(Cycle, ItsPeriodIsWhatItIsAndNoRoundNumberFarFromIt) {
  constexpr std::uint64_t us = 1'000;
  for (const std::uint64_t period :
       {3'100 * us,   11'000 * us,  12'500 * us,  13'000 * us,    14'000 * us,
        15'000 * us,  18'500 * us,  33'333 * us,  35'000 * us,    45'000 * us,
        70'000 * us,  98'500 * us,  105'000 * us, 109'500 * us,   110'000 * us,
        130'000 * us, 170'000 * us, 333'300 * us, 1'100'000 * us, 1'900'000 * us})
    for (const std::uint64_t count : {40U, 100U, 200U, 2000U})
      for (const std::uint64_t lost : {0U, 25U})
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
          const std::string what = std::to_string(period) + " x " + std::to_string(count) +
                                   ", one of " + std::to_string(lost) + ", seed " +
                                   std::to_string(seed) + "\n";
          const auto sent = cycle_of(period, count + 4000, seed, lost);
          const std::uint64_t end = kSecond + count * period;
          const Draft draft = drafted(test::before(sent, end), {}, {"can0"});
          const DraftChannel& is = draft.channels.at(0);
          EXPECT_TRUE(is.periodic) << what << draft.xml;
          EXPECT_NEAR(static_cast<double>(is.period), static_cast<double>(period),
                      static_cast<double>(period) * 0.02)
              << what << draft.xml;
          EXPECT_LT(is.jitter, period / 2) << what << draft.xml;
          Gate gate(draft);
          const test::Share dropped = test::from(sent, end, gate, [](const Sent&) { return true; });
          EXPECT_EQ(dropped.frames, 0U) << what << draft.xml;
        }
}

TEST(Cycle, APeriodThatPeopleStateIsTakenIfItIsWithinWhatWasSeen) {
  for (const std::uint64_t ms : {10U, 20U, 50U, 100U, 110U, 130U, 250U, 1000U})
    for (std::uint64_t seed = 1; seed <= 8; ++seed)
      for (const std::uint64_t count : {40U, 200U, 2000U})
        EXPECT_EQ(drafted(cycle_of(ms * kMs, count, seed), {}, {"can0"}).channels.at(0).period,
                  ms * kMs)
            << seed << " x " << count;
}

// --- what is said of them ------------------------------------------------------------------------

bool says(const Draft& draft, std::string_view text) {
  return std::ranges::any_of(draft.left_out,
                             [&](const std::string& line) { return line.contains(text); });
}

TEST(Remarks, WhatIsThereForAPartOfTheTimeIsNamed) {
  test::Traffic traffic(7);
  traffic.periodic(0, 0x100, 100 * kMs, kMs, 8, 60);
  EXPECT_TRUE(drafted(traffic.sent(), {}, {"can0"}).left_out.empty());
  traffic.periodic(0, 0x101, 50 * kMs, kMs, 8, 30);
  const Draft ends = drafted(traffic.sent(), {}, {"can0"});
  EXPECT_TRUE(says(ends, "can0: nothing more came of 0x101 while others went on"));
  auto sent = test::Traffic(8).periodic(0, 0x100, 100 * kMs, kMs, 8, 60).sent();
  for (const Sent& one : test::Traffic(9).periodic(0, 0x102, 50 * kMs, kMs, 8, 60).sent())
    if (one.ns > 30 * kSecond) sent.push_back(one);
  std::ranges::sort(sent, {}, &Sent::ns);
  EXPECT_TRUE(says(drafted(sent, {}, {"can0"}), "can0: 0x102 began only when others"));
}

TEST(Remarks, OfEventsWithOneTimeStampThePeriodIsAssumed) {
  for (const std::size_t count : {2U, 1000U}) {
    const std::vector<Sent> sent(count, {.ns = kSecond, .id = 0x123, .data = {1}});
    const Draft draft = drafted(sent, {}, {"can0"});
    EXPECT_EQ(draft.channels.at(0).period, 100 * kMs);
    EXPECT_TRUE(draft.xml.contains("one time stamp: the Period is assumed")) << draft.xml;
    EXPECT_TRUE(says(draft, "all events of 0x123 have one time stamp"));
  }
}

/// 100 frames of each of 16 identifiers; of each `often` times that one comes, a frame comes with
/// the time of the one before it.
std::vector<Sent> read_at_once(std::uint64_t often, std::uint64_t apart) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 1600; ++i) {
    sent.push_back(
        {.ns = kSecond + i * kMs, .id = 0x100 + static_cast<std::uint32_t>(i % 16), .data = {1}});
    if (i % often == often - 1) {
      sent.push_back(sent.back());
      sent.back().ns += apart;
    }
  }
  return sent;
}

/// A frame takes 47 us on the fastest bus.
TEST(Remarks, TimesThatNoBusCanGiveAreNamed) {
  const std::string note = "can0: the times are not those of the bus";
  EXPECT_TRUE(says(drafted(read_at_once(100, 0), {}, {"can0"}), note));
  EXPECT_TRUE(says(drafted(read_at_once(100, 15'000), {}, {"can0"}), note));
  EXPECT_TRUE(says(drafted(read_at_once(160, 0), {}, {"can0"}), note));
  EXPECT_FALSE(says(drafted(read_at_once(400, 0), {}, {"can0"}), note)) << "a few may be";
  EXPECT_FALSE(says(drafted(read_at_once(100, 40'000), {}, {"can0"}), note));
  EXPECT_FALSE(says(drafted(read_at_once(1601, 0), {}, {"can0"}), note));
}

TEST(Remarks, OfTimesThatNoBusCanGiveTheShareIsSaid) {
  const Draft draft = drafted(read_at_once(2, 0), {}, {"can0"});
  EXPECT_TRUE(says(draft,
                   "can0: the times are not those of the bus: 33 % of 2400 frames are within 20us "
                   "of the one before, and 34 % of the events within 20us of the one before with "
                   "the same identifier"))
      << (draft.left_out.empty() ? "nothing" : draft.left_out.front());
  EXPECT_TRUE(says(draft, "do not rely on the Periods and Jitters of this draft"));
}

/// Frames of several identifiers that are read at once have late times, but none twice.
TEST(Remarks, TimesAtWhichSeveralIdentifiersWereReadAtOnceAreThoseOfTheBus) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 1600; ++i)
    sent.push_back({.ns = kSecond + i / 4 * 4 * kMs,
                    .id = 0x100 + static_cast<std::uint32_t>(i % 16),
                    .data = {1}});
  EXPECT_FALSE(says(drafted(sent, {}, {"can0"}), "the times are not those of the bus"));
}

TEST(Remarks, AnEthernetIsFasterThanABus) {
  std::vector<Sent> sent;
  for (std::uint64_t i = 0; i < 1600; ++i)
    sent.push_back(test::event(kSecond + i / 4 * 4 * kMs + i % 4 * 5'000, 0, test::kDistance,
                               test::station(7), {1}));
  EXPECT_FALSE(says(drafted(sent, {}, {"eth0"}), "the times are not those of the bus"));
}

TEST(Remarks, AProfileThatMayBeAnotherOneIsNamedWithTheOption) {
  test::Traffic traffic(10);
  traffic.periodic(0, 0x0c000003U | kExtended, 10 * kMs, 0, 8, 10)
      .periodic(0, 0x0cf00400U | kExtended, 20 * kMs, 0, 8, 10);
  EXPECT_TRUE(says(drafted(traffic.sent(), {}, {"can0"}), "state --profile can0=j1939"));
}

TEST(Remarks, ServiceDataOfCanopenIsNamed) {
  test::Traffic traffic(11);
  traffic.periodic(0, 0x185, 100 * kMs, 0, 8, 10).periodic(0, 0x585, kSecond, 0, 8, 10);
  auto sent = traffic.sent();
  for (std::uint64_t i = 0; i < 10; ++i)
    sent.push_back({.ns = (i + 1) * kSecond, .id = 0x705, .data = {5}});
  std::ranges::sort(sent, {}, &Sent::ns);
  const Draft draft = drafted(sent, {}, {"can0"});
  EXPECT_TRUE(says(draft, "SDOs were seen (0x585)"));
  EXPECT_TRUE(draft.xml.contains("an SDO, by which any entry of a node can be written"))
      << draft.xml;
}

}  // namespace
}  // namespace mlcca::learn
