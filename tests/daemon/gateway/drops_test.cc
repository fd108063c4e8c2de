// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/drops.hpp"

#include <gtest/gtest.h>

#include "base/drop_watch.hpp"

namespace mlcca {
namespace {

TEST(DropWatch, MentionsWhatIsNewAndNotTooOften) {
  DropWatch<std::string> watch;
  EXPECT_EQ(watch.sample("a", 5, 0), std::nullopt) << "of a daemon before this one";
  EXPECT_EQ(watch.sample("a", 7, 1), 2U);
  EXPECT_EQ(watch.sample("a", 9, 60), std::nullopt);
  EXPECT_EQ(watch.sample("a", 9, 61), 2U);
  EXPECT_EQ(watch.sample("a", 9, 200), std::nullopt);
}

TEST(DropWatch, WhatComesLaterBeginsAtNothing) {
  DropWatch<std::string> watch;
  watch.sample("a", 5, 0);
  watch.end_round();
  EXPECT_EQ(watch.sample("b", 3, 1), 3U) << "was not there before";
  EXPECT_EQ(watch.sample("a", 4, 1), std::nullopt) << "was read while it was counted";
  EXPECT_EQ(watch.sample("a", 5, 1), std::nullopt);
  EXPECT_EQ(watch.sample("a", 2000, 1), 1995U);
  EXPECT_EQ(watch.sample("a", 0, 100), std::nullopt);
  EXPECT_EQ(watch.sample("a", 2, 161), 2U) << "has started again";
}

TEST(DropWatch, WhatIsGoneForARoundIsForgotten) {
  DropWatch<std::string> watch;
  watch.sample("a", 5, 0);
  watch.end_round();
  watch.end_round();
  EXPECT_EQ(watch.sample("a", 5, 1), 5U);
  watch.forget();
  EXPECT_EQ(watch.sample("a", 9, 2), std::nullopt);
}

TEST(DropWatch, WhatIsGoneGivesItsMemoryBackInPieces) {
  DropWatch<int> watch;
  for (int key = 0; key < 1000; ++key) watch.sample(key, 1, 0);
  watch.end_round();
  for (int key = 0; key < 1000; key += 2) watch.sample(key, 1, 1);
  watch.end_round();
  ASSERT_TRUE(watch.tidy());
  EXPECT_GT(watch.size(), 900U) << "a piece of it";
  while (watch.tidy()) {
  }
  EXPECT_EQ(watch.size(), 500U);
  EXPECT_EQ(watch.sample(2, 3, 2), 2U) << "stays";
  EXPECT_EQ(watch.sample(3, 3, 2), 3U) << "begins at nothing";
}

TEST(DropWatch, SaysInWhatTimeTheRecentOnesWereDropped) {
  DropWatch<std::string> watch;
  watch.sample("a", 5, 10);
  watch.sample("a", 9, 11);
  EXPECT_EQ(watch.recent("a", 11), (RecentDrops{4, 1})) << "since the sample before";
  watch.sample("a", 12, 40);
  EXPECT_EQ(watch.recent("a", 52), (RecentDrops{7, 42}));
  watch.forget();
  watch.sample("a", 12, 60);
  EXPECT_EQ(watch.recent("a", 60), RecentDrops{});
  watch.sample("a", 30, 61);
  EXPECT_EQ(watch.recent("a", 70), (RecentDrops{18, 10}));
}

/// A gateway of ten thousand channels would spend most of its memory on what never happens.
/// As Drift counts what was sent past a gate.
TEST(DropWatch, WhoCountsFromNothingIsMentionedAtOnce) {
  DropWatch<std::string> watch;
  watch.end_round();
  EXPECT_EQ(watch.sample("a", 0, 1), std::nullopt);
  EXPECT_EQ(watch.sample("a", 200, 1), 200U);
}

TEST(DropWatch, CountersThatAreNothingTakeNoMemory) {
  DropWatch<int> watch;
  for (int key = 0; key < 1000; ++key) watch.sample(key, 0, 0);
  watch.end_round();
  for (int key = 0; key < 1000; ++key) EXPECT_EQ(watch.sample(key, 0, 1), std::nullopt);
  EXPECT_EQ(watch.close(1, 0, 1), 0U);
  watch.end_round();
  EXPECT_EQ(watch.size(), 0U);
  EXPECT_EQ(watch.sample(7, 4, 3), 4U);
  EXPECT_EQ(watch.recent(7, 3), (RecentDrops{4, 2})) << "since the round before began, at 1 s";
  EXPECT_EQ(watch.size(), 1U);
}

TEST(DropWatch, WhatWasDroppedInTheLastFiveMinutesIsRecent) {
  DropWatch<std::string> watch;
  watch.sample("a", 5, 0);
  EXPECT_EQ(watch.recent("a", 0).frames, 0U) << "of a daemon before this one";
  EXPECT_EQ(watch.recent("b", 0).frames, 0U) << "it was not sampled";
  watch.sample("a", 7, 10);
  watch.sample("a", 12, 200);
  EXPECT_EQ(watch.recent("a", 200).frames, 7U) << "since the drops began, mentioned or not";
  EXPECT_EQ(watch.recent("a", 499).frames, 7U);
  EXPECT_EQ(watch.recent("a", 500).frames, 0U) << "300 s after the latest one";
  watch.sample("a", 13, 600);
  EXPECT_EQ(watch.recent("a", 600).frames, 1U) << "the drops of then are over";
  watch.sample("a", 0, 601);
  watch.sample("a", 2, 602);
  EXPECT_EQ(watch.recent("a", 602).frames, 2U) << "the counter has started again";
  watch.forget();
  EXPECT_EQ(watch.recent("a", 602).frames, 0U);
}

TEST(DropWatch, AwakeItMentionsTheRestAtOnce) {
  DropWatch<std::string> watch;
  watch.sample("a", 0, 0);
  watch.sample("b", 0, 0);
  watch.end_round();
  EXPECT_EQ(watch.sample("a", 1, 1), 1U);
  watch.wake();
  EXPECT_EQ(watch.sample("a", 4, 2), 3U);
  EXPECT_EQ(watch.sample("b", 0, 2), std::nullopt) << "nothing came";
  EXPECT_EQ(watch.sample("a", 5, 3), std::nullopt) << "once";
}

TEST(DropWatch, LineSaysWhatWouldBeInAuditMode) {
  EXPECT_EQ(dropped_line(Fate::dropped, 3, "of x"), "3 frames dropped of x");
  EXPECT_EQ(dropped_line(Fate::passed, 3, "of x"), "would be dropped: 3 frames of x");
}

}  // namespace
}  // namespace mlcca
