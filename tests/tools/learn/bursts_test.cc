// SPDX-License-Identifier: BSD-2-Clause
// Messages that come on events, also a few times only and soon after another: what is drafted of
// them is accepted by a check, takes little of the bus, and passes what was seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/tools/learn/drafted.hpp"
#include "tests/tools/learn/traffic.hpp"

namespace mlcca::learn {
namespace {

using test::drafted;
using test::Gate;
using test::in_order;
using test::kMs;
using test::kSecond;
using test::Sent;
using test::Traffic;

constexpr std::uint64_t kUs = 1'000;

/// 60 seconds of three cyclic messages.
Traffic plant() {
  Traffic traffic(7);
  traffic.periodic(0, 0x100, 10 * kMs, kMs / 2, 8, 60)
      .periodic(0, 0x200, 100 * kMs, kMs, 8, 60)
      .periodic(0, 0x300, 50 * kMs, kMs, 4, 60);
  return traffic;
}

/// The plant, and `count` frames of 0x700 so far apart.
std::vector<Sent> with_burst(std::uint64_t at, std::uint64_t count, std::uint64_t apart) {
  auto sent = plant().sent();
  for (std::uint64_t i = 0; i < count; ++i)
    sent.push_back({.ns = at + i * apart, .id = 0x700, .data = {1, 2}});
  return in_order(std::move(sent));
}

const DraftChannel& channel_of(const Draft& draft, const std::string& name) {
  const auto found = std::ranges::find(draft.channels, name, &DraftChannel::name);
  EXPECT_NE(found, draft.channels.end());
  return found == draft.channels.end() ? draft.channels.front() : *found;
}

void expect_all_passes(const Draft& draft, const std::vector<Sent>& sent, const std::string& what) {
  Gate gate(draft);
  const test::Share dropped = test::from(sent, 0, gate, [](const Sent&) { return true; });
  EXPECT_EQ(dropped.frames, 0U) << what << '\n' << draft.xml;
  EXPECT_EQ(std::ranges::count_if(draft.left_out,
                                  [](const std::string& note) { return note.contains("refuses"); }),
            0)
      << what << '\n'
      << draft.left_out.front();
}

TEST(Bursts, OfAFewFramesSoonAfterAnotherThePeriodIsNotTheirGap) {
  for (const std::uint64_t at : {kSecond, 30 * kSecond, 61 * kSecond - 5 * kMs})
    for (const auto& [count, apart] :
         {std::pair(2U, 200 * kUs), std::pair(3U, 300 * kUs), std::pair(2U, 38 * kUs)}) {
      const auto sent = with_burst(at, count, apart);
      const Draft draft = drafted(sent, {}, {"can0"});
      const DraftChannel& burst = channel_of(draft, "can0-700");
      EXPECT_GE(burst.period, 10 * kMs) << count << " at " << at;
      EXPECT_TRUE(burst.bursts) << count << " at " << at;
      EXPECT_FALSE(burst.periodic);
      EXPECT_TRUE(draft.xml.contains("bitrate=\"500000\"")) << draft.xml;
      expect_all_passes(draft, sent, "few");
    }
}

TEST(Bursts, ManyFramesInOneBurstAreNoCycle) {
  for (const std::uint64_t count : {10U, 40U, 500U}) {
    const auto sent = with_burst(30 * kSecond, count, 250 * kUs);
    const Draft draft = drafted(sent, {}, {"can0"});
    const DraftChannel& burst = channel_of(draft, "can0-700");
    EXPECT_TRUE(burst.bursts) << count;
    EXPECT_GE(burst.period, count < 100 ? kMs : 250 * kUs) << count;
    EXPECT_TRUE(draft.xml.contains("bitrate=\"500000\"")) << draft.xml;
    expect_all_passes(draft, sent, "many");
  }
}

TEST(Bursts, WhatIsCyclicAndBeganOrEndedInTheRecordingHasItsCycle) {
  for (const std::uint64_t at : {kSecond, 61 * kSecond - 200 * kMs}) {
    const auto sent = with_burst(at, 20, 10 * kMs);
    const Draft draft = drafted(sent, {}, {"can0"});
    EXPECT_LE(channel_of(draft, "can0-700").period, 10 * kMs) << at;
    expect_all_passes(draft, sent, "cyclic");
  }
}

TEST(Bursts, OfManyIdentifiersThatCameInBurstsACheckRefusesNothing) {
  auto traffic = plant();
  auto sent = traffic.sent();
  for (std::uint32_t id = 0x400; id < 0x480; ++id)
    for (std::uint64_t i = 0; i < 3; ++i)
      sent.push_back({.ns = kSecond + std::uint64_t{id - 0x400} * 100 * kMs + i * 250 * kUs,
                      .id = id,
                      .data = {1, 2, 3, 4, 5, 6, 7, 8}});
  sent = in_order(std::move(sent));
  const Draft draft = drafted(sent, {}, {"can0"});
  EXPECT_TRUE(draft.xml.contains("bitrate=\"500000\""));
  expect_all_passes(draft, sent, "identifiers");
}

TEST(Bursts, OfDatagramsThereIsTimeBetweenThem) {
  Traffic traffic(3);
  traffic.events(0, test::kDistance, test::station(7), 50 * kMs, kMs, 8, 20);
  auto sent = traffic.sent();
  for (std::uint64_t i = 0; i < 2; ++i)
    sent.push_back(
        test::event(10 * kSecond + i * 38 * kUs, 0, 0x1234567812345678, test::station(8), {1}));
  sent = in_order(std::move(sent));
  const Draft draft = drafted(sent, {}, {"eth0"});
  ASSERT_EQ(draft.channels.size(), 2U);
  for (const DraftChannel& one : draft.channels) EXPECT_GE(one.period, 10 * kMs) << one.name;
}

// --- at random -----------------------------------------------------------------------------------

struct BurstsTest : ::testing::TestWithParam<std::uint32_t> {};

/// Up to forty identifiers on one bus, each with bursts of its own at some times, that never take
/// more of the bus than it has.
TEST_P(BurstsTest, AtRandomAreAcceptedByACheckAndPass) {
  constexpr std::uint64_t frame_takes = 280 * kUs;
  std::mt19937_64 random(GetParam());
  const auto below = [&](std::uint64_t n) { return random() % n; };
  const std::uint64_t seconds = 5 + below(60);
  Traffic traffic(GetParam());
  for (std::uint32_t id = 0; id < 1 + below(3); ++id)
    traffic.periodic(0, 0x10 + id, (10 + below(100)) * kMs, below(kMs), 8, seconds);
  auto sent = traffic.sent();
  const std::uint64_t identifiers = 1 + below(40);
  constexpr std::array<std::uint64_t, 4> most = {2, 10, 50, 300};
  for (std::uint32_t id = 0; id < identifiers; ++id) {
    const std::uint64_t longest = most[below(most.size())];
    for (std::uint64_t times = 1 + below(6); times > 0; --times) {
      const std::uint64_t at = kSecond + below(seconds * kSecond);
      const std::uint64_t apart = 50 * kUs + below(below(2) == 0 ? kMs : 50 * kMs);
      for (std::uint64_t i = 0; i < 1 + below(longest); ++i)
        sent.push_back({.ns = at + i * apart + below(apart / 4),
                        .id = 0x100 + id,
                        .data = std::vector<std::uint8_t>(below(9), static_cast<std::uint8_t>(i))});
    }
  }
  sent = in_order(std::move(sent));
  std::uint64_t free = 0;  // as on a bus, one after the other
  for (Sent& one : sent) {
    one.ns = std::max(one.ns, free);
    free = one.ns + frame_takes;
  }
  std::erase_if(sent, [&](const Sent& one) { return one.ns > (seconds + 2) * kSecond; });
  const Draft draft = drafted(sent, {}, {"can0"});
  expect_all_passes(draft, sent, "seed " + std::to_string(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Seeds, BurstsTest, ::testing::Range(1U, 61U));

}  // namespace
}  // namespace mlcca::learn
