// SPDX-License-Identifier: BSD-2-Clause
// What a user pays for changes, and what never waits for that, in a whole gateway among fakes.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "daemon/gateway/quotas.hpp"
#include "tests/daemon/gateway/bench.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::size_t kMany = 1'000;

class ChangesQuota : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_FALSE(bench_.start()); }

  /// Why it is refused; empty: it is not.
  std::string refusal(decltype(control::Request::body) body) {
    const auto answer = bench_.ask(std::move(body));
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    return error == nullptr ? "" : error->message;
  }
  std::string reload() {
    std::string why = refusal(control::ReloadRequest{});
    if (why.empty()) bench_.reading().finish();
    bench_.act();
    return why;
  }
  /// Reloads at one moment until one is refused: how many were not.
  std::size_t flood(bool with_changes = false) {
    const core::System whole = bench_.system;
    for (std::size_t n = 0; n < kMany; ++n) {
      if (with_changes && n % 2 == 0)
        bench_.system.subscribers.clear();
      else
        bench_.system = whole;
      if (!reload().empty()) return n;
    }
    return kMany;
  }

  Bench bench_{small_system()};
};

TEST_F(ChangesQuota, ReloadsOfADayLeaveRoomForOtherChanges) {
  for (int n = 0; n < 100; ++n) ASSERT_EQ(reload(), "") << "reload " << n;
  EXPECT_EQ(refusal(newcomer()), "");
}

TEST_F(ChangesQuota, AFloodOfReloadsEnds) {
  const std::size_t most = Quotas::kRowsOfUser.at_once / Quotas::kRowsOfReload;
  EXPECT_LE(flood(), most);
}

TEST_F(ChangesQuota, AReloadPaysForWhatItReports) {
  const std::size_t without = flood();
  bench_.clock.monotonic += 3600 * kSecond;
  EXPECT_LT(flood(true), without);
}

TEST_F(ChangesQuota, ARefusedReloadSaysWhenTheNextOneIsTaken) {
  flood();
  const std::string why = reload();
  const std::string words = "ask again in ";
  ASSERT_TRUE(why.contains(words)) << why;
  const auto seconds = std::stoul(why.substr(why.find(words) + words.size()));
  bench_.clock.monotonic += (seconds - 1) * kSecond;
  EXPECT_NE(reload(), "") << why;
  bench_.clock.monotonic += kSecond;
  EXPECT_EQ(reload(), "") << why;
  EXPECT_TRUE(reload().contains("ask again in 10 s")) << "some 50 rows, 5 a second";
}

TEST_F(ChangesQuota, WhatTakesAwayDoesNotWait) {
  ASSERT_EQ(refusal(newcomer()), "");
  bench_.act();
  flood();
  std::size_t rows = 0;
  while (rows < kMany && refusal(control::ModeRequest{"audit"}).empty()) ++rows;
  ASSERT_LT(rows, kMany);
  ASSERT_TRUE(refusal(newcomer()).contains("rows of the history"));
  EXPECT_EQ(refusal(control::WithdrawRequest{"c0"}), "");
  EXPECT_EQ(bench_.state().granted(), 1U) << "the admitted one";
  EXPECT_EQ(refusal(control::ReleaseRequest{"", 1, ""}), "");
  EXPECT_EQ(refusal(control::ModeRequest{"enforce"}), "");
  EXPECT_EQ(bench_.kernel.mode, gates::Mode::enforce);
  EXPECT_TRUE(refusal(control::ModeRequest{"enforce"}).contains("rows of the history"))
      << "it takes nothing away any more";
  EXPECT_TRUE(refusal(control::ModeRequest{"audit"}).contains("rows of the history"));
  EXPECT_TRUE(refusal(control::ReinstateRequest{"c0"}).contains("rows of the history"));
}

}  // namespace
}  // namespace mlcca::test
