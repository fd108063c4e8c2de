// SPDX-License-Identifier: BSD-2-Clause
// The pages in which the history goes to a client, over a real database.
#include "daemon/gateway/history_pages.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "tests/daemon/store/worlds.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kStart = 1'700'000'000'000'000'000;  // ns since 1970
constexpr std::size_t kPage = HistoryPages::kPage;

class HistoryPagesTest : public ::testing::Test {
 protected:
  /// The messages of the rows are 0, 1, 2, …
  void append(std::size_t count, std::uint64_t step_ns = 1) {
    for (; count > 0; --count) {
      now_ += step_ns;
      history_.append({now_, "granted", 1, "video", "", "", "", std::to_string(appended_++)});
    }
  }
  HistoryPages pages(std::size_t limit, store::HistoryFilter filter = {}) {
    filter.limit = limit;
    return {history_, std::move(filter)};
  }
  static std::vector<std::string> page(HistoryPages& from) {
    const auto page = from.next();
    EXPECT_TRUE(page);
    std::vector<std::string> messages;
    for (const control::HistoryEntry& entry : page->entries) messages.push_back(entry.message);
    return messages;
  }
  /// All of them; `between` is called after each.
  static std::vector<std::string> rest(
      HistoryPages& from, const std::function<void()>& between = [] {}) {
    std::vector<std::string> all;
    while (from.more()) {
      for (std::string& message : page(from)) all.push_back(std::move(message));
      between();
    }
    return all;
  }
  /// From the row `newest` down.
  static std::vector<std::string> down_from(std::size_t newest, std::size_t count) {
    std::vector<std::string> all;
    for (; count > 0; --count) all.push_back(std::to_string(newest--));
    return all;
  }

  store::test::Folder folder_;
  store::History history_ = store::History::open(folder_.path());
  std::uint64_t now_ = kStart;
  std::size_t appended_ = 0;
};

TEST_F(HistoryPagesTest, AnEmptyHistoryIsOneEmptyPage) {
  auto all = pages(100);
  EXPECT_TRUE(all.more());
  EXPECT_TRUE(page(all).empty());
  EXPECT_FALSE(all.more());
}

TEST_F(HistoryPagesTest, HaveEveryRowOnceTheNewestFirst) {
  append(3 * kPage + 7);
  history_.flush(now_);
  auto all = pages(10'000);
  EXPECT_EQ(page(all), down_from(appended_ - 1, kPage));
  EXPECT_EQ(rest(all), down_from(appended_ - 1 - kPage, 2 * kPage + 7));
}

TEST_F(HistoryPagesTest, HaveEveryRowOnceAlsoWhereTheClockWasSetBack) {
  append(2 * kPage);
  history_.flush(now_);
  now_ = kStart - 2 * kPage;  // earlier than all that is written
  append(kPage);
  auto all = pages(10'000);
  std::vector<std::string> expected = down_from(2 * kPage - 1, 2 * kPage);
  for (std::string& message : down_from(3 * kPage - 1, kPage)) expected.push_back(message);
  EXPECT_EQ(rest(all), expected);
}

TEST_F(HistoryPagesTest, EndWhereTheLimitDoes) {
  append(3 * kPage);
  history_.flush(now_);
  for (const std::size_t limit : {std::size_t{1}, kPage - 1, kPage, kPage + 1, 2 * kPage}) {
    auto some = pages(limit);
    EXPECT_EQ(rest(some), down_from(appended_ - 1, limit));
  }
}

TEST_F(HistoryPagesTest, ManyRowsOfOneMomentAreNeitherLostNorRepeated) {
  append(5);
  append(3 * kPage, 0);
  append(5);
  history_.flush(now_);
  auto all = pages(10'000);
  EXPECT_EQ(rest(all), down_from(appended_ - 1, appended_));
}

TEST_F(HistoryPagesTest, RowsThatWaitForTheDiskCountAndMayGoThereMeanwhile) {
  append(kPage + 10);
  history_.flush(now_);
  append(kPage + 10);
  auto all = pages(10'000);
  EXPECT_EQ(rest(all, [this] { history_.flush(now_); }), down_from(appended_ - 1, appended_));
}

TEST_F(HistoryPagesTest, WhatComesMeanwhileIsNotAmongThem) {
  append(2 * kPage + 10);
  history_.flush(now_);
  const std::size_t before = appended_;
  auto all = pages(10'000);
  EXPECT_EQ(rest(all,
                 [this] {
                   append(50);
                   history_.flush(now_);
                 }),
            down_from(before - 1, before));
}

TEST_F(HistoryPagesTest, KeepToTheFilter) {
  append(2 * kPage);
  history_.append({++now_, "refused", 2, "audio", "", "", "", "another"});
  append(2 * kPage);
  history_.flush(now_);
  store::HistoryFilter filter;
  filter.kind = "refused";
  auto refused = pages(10'000, filter);
  EXPECT_EQ(rest(refused), std::vector<std::string>{"another"});
  filter.kind.clear();
  filter.since_ns = kStart + 10;
  filter.until_ns = kStart + 20;
  auto some = pages(10'000, filter);
  EXPECT_EQ(rest(some), down_from(19, 11));
}

}  // namespace
}  // namespace mlcca
