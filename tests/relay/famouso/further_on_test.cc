// SPDX-License-Identifier: BSD-2-Clause
// What gateways further on answer, and who is told of it.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "relay/famouso/subscriptions.hpp"
#include "tests/relay/famouso/subscriptions_scene.hpp"

namespace mlcca::relay {
namespace {

using FurtherOnTest = SubscriptionsTest;

TEST_F(FurtherOnTest, WhoHasComeOverAsManyGatewaysAsMayBeIsNotPassedOn) {
  Subscription last = wanted(5);
  last.hops = 0;
  come("0x12", last);
  answer(granted());
  take_sent();
  say_onward(7'000'000);
  subscriptions_.set(said_, 0);
  EXPECT_EQ(told("bus"),
            std::vector<std::string>{
                "5 refused: it has come over as many gateways as may be: no further one "
                "passes it on"});
  say_onward(8'000'000);
  subscriptions_.set(said_, 0);
  EXPECT_TRUE(take_sent().empty()) << "it was answered";
  come("0x13", wanted(6), kSecond);
  answer(granted(), kSecond);
  say_onward(6'000'000);
  subscriptions_.set(said_, kSecond);
  EXPECT_EQ(told("bus"), (std::vector<std::string>{"6 granted", "5 granted"}))
      << "another one has it passed on";
}

TEST_F(FurtherOnTest, WhatBeginsHereIsPassedOnWhateverPeersHaveLeft) {
  Subscription last = wanted(5);
  last.hops = 0;
  come("0x12", last);
  answer(granted());
  say_onward(7'000'000, true);
  subscriptions_.set(said_, 0);
  std::vector<std::uint8_t> hops;
  for (const Sent& one : take_sent())
    if (one.message.kind == Kind::subscribe) hops.push_back(one.message.hops);
  EXPECT_EQ(hops, std::vector<std::uint8_t>{7});
}

TEST_F(FurtherOnTest, AnAnswerToWhatWasRequiredBeforeIsNone) {
  const std::uint32_t first = subscribe_and_pass_on("0x12", 5, 10'000'000);
  const std::uint32_t second = subscribe_and_pass_on("0x12", 5, 9'000'000, 1);
  EXPECT_NE(first, second);
  answer_further_on(Kind::refused, first, "of 10 ms");
  EXPECT_TRUE(told("bus").empty());
  EXPECT_TRUE(reports_.empty());
  answer_further_on(Kind::refused, second, "of 9 ms");
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 refused: 192.0.2.9 on lan: of 9 ms"});
}

TEST_F(FurtherOnTest, OfSeveralGatewaysFurtherOnOneThatGrantsIsEnough) {
  const std::uint32_t number = subscribe_and_pass_on("0x12", 5, 10'000'000);
  answer_further_on(Kind::refused, number, "no way", "192.0.2.8");
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 refused: 192.0.2.8 on lan: no way"});
  answer_further_on(Kind::granted, number, "", "192.0.2.9");
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 granted"});
  ASSERT_EQ(reports_.size(), 2U);
  EXPECT_EQ(reports_[0].reason, "no way");
  EXPECT_EQ(reports_[1].reason, "") << "programs here are told, too";
  answer_further_on(Kind::refused, number, "no way", "192.0.2.8");
  answer_further_on(Kind::granted, number, "", "192.0.2.9");
  EXPECT_TRUE(told("bus").empty());
  EXPECT_EQ(reports_.size(), 2U) << "at each renewal";
  answer_further_on(Kind::refused, number, "too late", "192.0.2.9");
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 refused: 192.0.2.8 on lan: no way"});
  EXPECT_EQ(reports_.back().reason, "no way");
  // A gateway that is not there any more grants nothing.
  answer_further_on(Kind::granted, number, "", "192.0.2.9", kSecond);
  answer_further_on(Kind::refused, number, "no way", "192.0.2.8", 59 * kSecond);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 granted"});
  answer_further_on(Kind::refused, number, "no way", "192.0.2.8", 62 * kSecond);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 refused: 192.0.2.8 on lan: no way"});
}

TEST_F(FurtherOnTest, WhatNobodyPassesOnAnyMoreIsNotRefusedAnyMore) {
  const std::uint32_t number = subscribe_and_pass_on("0x12", 5, 10'000'000);
  answer_further_on(Kind::refused, number, "no way");
  EXPECT_EQ(told("bus").size(), 1U);
  said_.onward.clear();  // for example its publisher is on the bus now
  subscriptions_.set(said_, 0);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 granted"});
}

TEST_F(FurtherOnTest, OnlyWhoAsksForTheImpossibleIsRefused) {
  const std::uint32_t first = subscribe_and_pass_on("0x12", 5, 10'000'000);
  answer_further_on(Kind::granted, first);
  take_sent();
  const std::uint32_t both = subscribe_and_pass_on("0x13", 6, 3'000'000, kSecond);
  answer_further_on(Kind::refused, both, "Latency 9 ms", "192.0.2.9", kSecond);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"6 refused: 192.0.2.9 on lan: Latency 9 ms"});
  EXPECT_TRUE(reports_.empty()) << "programs here lose nothing";
  // It is no admission any more, so that what it requires counts no more.
  subscriptions_.turn(kSecond);
  ASSERT_EQ(asked_.size(), 3U);
  EXPECT_TRUE(asked_[2].end);
  EXPECT_EQ(asked_[2].source, "0x13");
  answer_further_on(Kind::refused, both, "Latency 9 ms", "192.0.2.8", kSecond);
  EXPECT_TRUE(told("bus").empty()) << "that has been answered";
  answer(granted(), kSecond);
  say_onward(10'000'000);
  subscriptions_.set(said_, 2 * kSecond);
  const std::uint32_t again = sent_on_lan();
  EXPECT_NE(again, 0U);
  answer_further_on(Kind::granted, again, "", "192.0.2.9", 2 * kSecond);
  EXPECT_TRUE(told("bus").empty());
  // It may ask again after a while, and nobody else loses anything.
  come("0x13", wanted(7, 3'000'000), 5 * kSecond);
  EXPECT_EQ(asked_.size(), 3U);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"7 refused: 192.0.2.9 on lan: Latency 9 ms"});
  come("0x13", wanted(8, 3'000'000), 12 * kSecond);
  EXPECT_EQ(asked_.size(), 4U);
}

TEST_F(FurtherOnTest, WhoComesBesideProgramsHereAndAsksForTheImpossibleIsRefusedAlone) {
  come("0x12", wanted(5, 3'000'000));
  answer(granted());
  say_onward(3'000'000, true);
  subscriptions_.set(said_, 0);
  const std::uint32_t number = sent_on_lan();
  answer_further_on(Kind::refused, number, "Latency 9 ms");
  EXPECT_EQ(told("bus").size(), 1U);
  EXPECT_TRUE(reports_.empty());
  subscriptions_.turn(0);
  EXPECT_TRUE(asked_.back().end);
}

/// Of two that come together nobody knows at first which one asks for too much.
TEST_F(FurtherOnTest, WhoComesAfterOneThatIsRefusedIsTriedWithoutIt) {
  come("0x12", wanted(5, 3'000'000));
  answer(granted());
  const std::uint32_t both = subscribe_and_pass_on("0x13", 6, 3'000'000);
  answer_further_on(Kind::refused, both, "3 ms");
  EXPECT_EQ(told("bus"), std::vector<std::string>{"6 refused: 192.0.2.9 on lan: 3 ms"});
  subscriptions_.turn(0);
  answer(granted());  // of its end
  // Nothing else is required without it; it is tried again all the same.
  subscriptions_.set(said_, kSecond);
  subscriptions_.turn(2 * kSecond);
  const std::uint32_t alone = sent_on_lan();
  EXPECT_NE(alone, 0U);
  answer_further_on(Kind::refused, alone, "3 ms", "192.0.2.9", 2 * kSecond);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"5 refused: 192.0.2.9 on lan: 3 ms"});
  EXPECT_EQ(reports_.size(), 1U);
  // The one that could be served comes again: the other one stands back.
  const std::size_t before = asked_.size();
  come("0x13", wanted(7, 20'000'000), 11 * kSecond);
  answer(granted(), 11 * kSecond);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"7 granted"});
  ASSERT_EQ(asked_.size(), before + 2);
  EXPECT_TRUE(asked_.back().end);
  EXPECT_EQ(asked_.back().source, "0x12");
  answer(granted(), 11 * kSecond);
  say_onward(20'000'000);
  subscriptions_.set(said_, 12 * kSecond);
  const std::uint32_t next = sent_on_lan();
  EXPECT_NE(next, 0U);
  answer_further_on(Kind::granted, next, "", "192.0.2.9", 12 * kSecond);
  EXPECT_TRUE(told("bus").empty());
}

TEST_F(FurtherOnTest, ARefusalFurtherOnTravelsBackToWhoSubscribed) {
  come("0x12", wanted(5));
  answer(granted());
  say_onward(7'000'000);
  subscriptions_.set(said_, 0);
  take_sent();
  Subscription no{.kind = Kind::refused, .subject = kDistance, .number = 77};
  no.reason = "far to lan: Latency 9 ms";
  come("192.0.2.9", no, 0, "lan");
  ASSERT_EQ(reports_.size(), 1U);
  EXPECT_EQ(reports_[0].network, "lan");
  EXPECT_EQ(reports_[0].source, "192.0.2.9");
  EXPECT_EQ(reports_[0].reason, "far to lan: Latency 9 ms");
  auto sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].network, "bus");
  EXPECT_EQ(sent[0].message.kind, Kind::refused);
  EXPECT_EQ(sent[0].message.reason, "192.0.2.9 on lan: far to lan: Latency 9 ms");
  come("192.0.2.9", no, 0, "lan");  // once
  EXPECT_EQ(reports_.size(), 1U);
  EXPECT_TRUE(take_sent().empty());
  come("192.0.2.9", {.kind = Kind::granted, .subject = kDistance, .number = 77}, 0, "lan");
  sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::granted);
  // Of another subscription: not ours.
  come("192.0.2.9", {.kind = Kind::refused, .subject = kDistance, .number = 78}, 0, "lan");
  EXPECT_TRUE(take_sent().empty());
}

}  // namespace
}  // namespace mlcca::relay
