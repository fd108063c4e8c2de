// SPDX-License-Identifier: BSD-2-Clause
// Whom a gateway answers what, what it asks the daemon, and what it passes on.
#include "relay/famouso/subscriptions.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/relay/famouso/subscriptions_scene.hpp"

namespace mlcca::relay {
namespace {

TEST_F(SubscriptionsTest, TheDaemonDecidesAndThePeerIsAnswered) {
  come("0x12", wanted(5));
  ASSERT_EQ(asked_.size(), 1U);
  EXPECT_EQ(asked_[0].network, "bus");
  EXPECT_EQ(asked_[0].source, "0x12");
  EXPECT_EQ(asked_[0].subject, kDistance);
  EXPECT_TRUE(asked_[0].states_attributes);
  EXPECT_EQ(asked_[0].lease_ns, 60 * kSecond);
  ASSERT_EQ(asked_[0].required.size(), 1U);
  EXPECT_EQ(asked_[0].required[0].name, "Latency");
  EXPECT_TRUE(take_sent().empty());
  answer(granted());
  const auto sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].network, "bus");
  EXPECT_EQ(sent[0].message.kind, Kind::granted);
  EXPECT_EQ(sent[0].message.number, 5U);
}

TEST_F(SubscriptionsTest, ARefusalNamesTheHopAndIsRepeatedWithoutAskingAgain) {
  come("0x12", wanted(5));
  answer(refused("bus: 12 ms of the 10 ms"));
  auto sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::refused);
  EXPECT_EQ(sent[0].message.reason, "lan to bus: bus: 12 ms of the 10 ms");
  come("0x12", wanted(5), kSecond);
  EXPECT_EQ(asked_.size(), 1U);
  sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::refused);
  // With another requirement, or later, it is another question.
  come("0x12", wanted(5, 20'000'000), 2 * kSecond);
  EXPECT_EQ(asked_.size(), 2U);
  answer(refused("still not"), 2 * kSecond);
  come("0x12", wanted(5, 20'000'000), 13 * kSecond);
  EXPECT_EQ(asked_.size(), 3U);
}

TEST_F(SubscriptionsTest, WhatIsNotRenewedEnds) {
  come("0x12", wanted(5));
  answer(granted());
  come("0x12", wanted(5), 30 * kSecond);
  answer(granted(), 30 * kSecond);
  subscriptions_.turn(89 * kSecond);
  EXPECT_EQ(subscriptions_.peers(), 1U);
  EXPECT_EQ(asked_.size(), 2U);
  subscriptions_.turn(90 * kSecond);
  EXPECT_EQ(subscriptions_.peers(), 0U);
  ASSERT_EQ(asked_.size(), 3U);
  EXPECT_TRUE(asked_[2].end);
  EXPECT_EQ(asked_[2].source, "0x12");
}

TEST_F(SubscriptionsTest, WhoEndsItIsForgottenByTheDaemonToo) {
  come("0x12", wanted(5));
  answer(granted());
  come("0x12", {.kind = Kind::end, .subject = kDistance, .number = 5}, kSecond);
  subscriptions_.turn(kSecond);
  ASSERT_EQ(asked_.size(), 2U);
  EXPECT_TRUE(asked_[1].end);
  EXPECT_EQ(subscriptions_.peers(), 0U);
}

TEST_F(SubscriptionsTest, NodesOfFamousoCountWhereThePolicySaysSo) {
  come("0x12", {.subject = kDistance});
  EXPECT_TRUE(asked_.empty());
  said_.networks[0].accepts_all = true;
  subscriptions_.set(said_, 0);
  come("0x12", {.subject = kDistance});
  ASSERT_EQ(asked_.size(), 1U);
  EXPECT_FALSE(asked_[0].states_attributes);
  EXPECT_EQ(asked_[0].lease_ns, 0U);
  answer(granted());
  EXPECT_TRUE(take_sent().empty());  // they expect no answer
  subscriptions_.turn(1'000'000 * kSecond);
  EXPECT_EQ(subscriptions_.peers(), 1U);  // they subscribe once, for ever
  // On a network that accepts none, nobody is heard.
  come("192.0.2.7", {.subject = kDistance}, 0, "elsewhere");
  EXPECT_EQ(asked_.size(), 1U);
}

TEST_F(SubscriptionsTest, ANetworkHasNoMoreThanItAllows) {
  for (unsigned i = 0; i < 4; ++i) {
    come("0x1" + std::to_string(i), wanted(i));
    answer(granted());
  }
  take_sent();
  come("0x20", wanted(9));
  EXPECT_EQ(asked_.size(), 4U);
  const auto sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::refused);
  EXPECT_EQ(sent[0].message.reason, "bus has as many subscriptions as it allows");
  EXPECT_EQ(subscriptions_.peers(), 4U);
}

TEST_F(SubscriptionsTest, WhatIsRequiredFurtherOnIsPassedOnAndRenewedAndEnded) {
  come("0x12", wanted(5));
  answer(granted());
  take_sent();
  say_onward(7'000'000);
  subscriptions_.set(said_, 0);
  auto sent = take_sent();
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_EQ(sent[0].network, "lan");
  EXPECT_EQ(sent[0].message.kind, Kind::subscribe);
  EXPECT_EQ(sent[0].message.required[Attribute::latency], 7'000'000U);
  EXPECT_EQ(sent[0].message.lease_s, 60);
  EXPECT_EQ(sent[0].message.hops, 7);
  EXPECT_EQ(sent[1].message.kind, Kind::plain);  // for gateways of FAMOUSO, once
  subscriptions_.turn(Subscriptions::kRenewal);
  sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::subscribe);
  say_onward(6'000'000);
  subscriptions_.set(said_, Subscriptions::kRenewal + 1);
  ASSERT_EQ(take_sent().size(), 1U);
  said_.onward.clear();
  subscriptions_.set(said_, Subscriptions::kRenewal + 2);
  sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::end);
  EXPECT_EQ(subscriptions_.own(), 0U);
}

/// It changes its requirement while the daemon decides the former one.
TEST_F(SubscriptionsTest, TheDaemonsAnswerToAFormerRequirementIsNone) {
  come("0x12", wanted(5, 3'000'000));
  come("0x12", wanted(6, 20'000'000));
  ASSERT_EQ(asked_.size(), 2U);
  answer(refused("Latency 3 ms required"));
  EXPECT_TRUE(take_sent().empty());
  answer(granted());
  EXPECT_EQ(told("bus"), std::vector<std::string>{"6 granted"});
}

/// The daemon reports a question in vain before it answers it, and is asked once more because of
/// that.
TEST_F(SubscriptionsTest, AnAnswerCountsThoughTheSameIsAskedAgainMeanwhile) {
  come("0x12", wanted(5));
  answer(granted());
  take_sent();
  come("0x12", wanted(6, 3'000'000), kSecond);
  subscriptions_.decided(kDistance);
  subscriptions_.turn(kSecond);
  ASSERT_EQ(open_.size(), 2U);
  answer(refused("Latency 3 ms required"), kSecond);
  EXPECT_EQ(told("bus"), std::vector<std::string>{"6 refused: lan to bus: Latency 3 ms required"});
  subscriptions_.decided(kDistance);
  subscriptions_.turn(kSecond);
  EXPECT_EQ(asked_.size(), 3U);
}

TEST_F(SubscriptionsTest, WhatTheDaemonDecidesLaterIsReportedToThePeer) {
  come("0x12", wanted(5));
  answer(granted());
  take_sent();
  subscriptions_.decided(kDistance);
  subscriptions_.turn(kSecond);
  answer(refused("lan is down"), kSecond);
  auto sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::refused);
  // The daemon has it still: its lease is renewed, and it may be granted again.
  come("0x12", wanted(5), 30 * kSecond);
  EXPECT_EQ(asked_.size(), 3U);
  answer(refused("lan is down"), 30 * kSecond);
  take_sent();
  subscriptions_.decided(kDistance);
  subscriptions_.turn(40 * kSecond);
  answer(granted(), 40 * kSecond);
  sent = take_sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].message.kind, Kind::granted);
  subscriptions_.turn(90 * kSecond);
  ASSERT_EQ(asked_.size(), 5U);
  EXPECT_TRUE(asked_[4].end);
}

/// A question in vain is recorded by the daemon, which reports that to all its clients.
TEST_F(SubscriptionsTest, WhatWasRefusedIsNotAskedAgainAtOnceThoughItIsAdmittedAsItWasBefore) {
  come("0x12", wanted(5));
  answer(granted());
  come("0x12", wanted(6, 3'000'000), kSecond);
  ASSERT_EQ(asked_.size(), 2U);
  answer(refused("Latency 3 ms required"), kSecond);
  for (std::uint64_t now = kSecond; now < 10 * kSecond; now += kSecond) {
    subscriptions_.decided(kDistance);
    subscriptions_.turn(now);
    come("0x12", wanted(7, 3'000'000), now);
  }
  EXPECT_EQ(asked_.size(), 2U);
  EXPECT_EQ(take_sent().back().message.reason, "lan to bus: Latency 3 ms required");
  subscriptions_.turn(11 * kSecond);
  EXPECT_EQ(asked_.size(), 3U) << "later there may be room";
  come("0x12", wanted(8, 9'000'000), 11 * kSecond);
  answer(refused("Latency 3 ms required"), 11 * kSecond);
  EXPECT_EQ(asked_.size(), 4U) << "another requirement is another question";
}

TEST_F(SubscriptionsTest, ADaemonThatIsAwayIsAskedWhenItIsBack) {
  connected_ = false;
  come("0x12", wanted(5));
  EXPECT_TRUE(asked_.empty());
  connected_ = true;
  subscriptions_.turn(kSecond);
  EXPECT_EQ(asked_.size(), 1U);
  subscriptions_.daemon_gone();
  open_.clear();
  subscriptions_.ask_all();
  subscriptions_.turn(2 * kSecond);
  EXPECT_EQ(asked_.size(), 2U);
}

}  // namespace
}  // namespace mlcca::relay
