// SPDX-License-Identifier: BSD-2-Clause
// Deliveries over other gateways, which have to agree to one of the admissions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "tests/core/shared/gateways.hpp"

namespace mlcca::core::testing {
namespace {

constexpr AdmissionId kFirst = 1;   ///< a publisher on own0 with a subscriber on own1
constexpr AdmissionId kSecond = 2;  ///< a subscriber at the other gateway
constexpr std::size_t kOther = 1;

/// The first gateway has admitted both, and everything is reserved that they take of the bus.
class AgreementsTest : public ::testing::Test {
 protected:
  explicit AgreementsTest(System described = networks(false))
      : system_(std::move(described)), channel_(add_channel(system_, every(50 * kMs))) {}

  void start() {
    pair_.emplace(system_);
    permits().need_agreements();
    Admission first = both_ends(channel_, kFirst, every(50 * kMs));
    first.subscriber->place = on(kOwn + 1);
    state().restore(std::move(first));
    state().restore({.id = kSecond,
                     .channel = channel_,
                     .publisher = {},
                     .subscriber = subscriber(channel_, at(kOther), every(50 * kMs))});
    static_cast<void>(state().settle());
    footprint_ = cluster::footprint_of(state().wish(channel_), pair_->baseline, 0);
  }
  Permits& permits() { return (*pair_)[0].permits; }
  State& state() { return (*pair_)[0].state; }
  /// All of it is reserved with that number, and these gateways agree to these admissions.
  void hold(std::uint64_t number, std::vector<AdmissionId> admissions,
            std::vector<std::size_t> gateways) {
    permits().put(number, footprint_, false,
                  {.admissions = std::move(admissions), .gateways = std::move(gateways)});
    static_cast<void>(state().settle());
  }
  void give_back(std::uint64_t number) {
    permits().erase(number);
    static_cast<void>(state().settle());
  }
  const Verdict& towards(Place place) {
    const auto& verdicts = state().decisions()[channel_].verdicts;
    return *std::ranges::find(verdicts, place, &Verdict::to);
  }
  bool is_granted(Place place) { return towards(place).granted; }

  System system_;
  std::size_t channel_;
  std::optional<Pair> pair_;
  cluster::Footprint footprint_;
};

TEST_F(AgreementsTest, TheOtherGatewayHasToAgreeAsLongAsItLasts) {
  start();
  hold(1, {kFirst}, {});
  EXPECT_EQ(towards(on(kOwn + 1)).obstacle, Obstacle::disagreed);
  EXPECT_EQ(towards(on(kOwn + 1)).obstacle_at, at(kOther));
  hold(1, {kFirst}, {kOther});
  EXPECT_TRUE(is_granted(on(kOwn + 1)));
  give_back(1);
  EXPECT_FALSE(is_granted(on(kOwn + 1)));
}

TEST_F(AgreementsTest, ThatOfThePublisherCountsForItsOwnSubscriberOnly) {
  start();
  hold(1, {kFirst}, {kOther});
  EXPECT_TRUE(is_granted(on(kOwn + 1)));
  EXPECT_EQ(towards(at(kOther)).obstacle, Obstacle::disagreed);
  hold(2, {kSecond}, {kOther});
  EXPECT_TRUE(is_granted(at(kOther)));
  give_back(1);
  hold(3, {}, {});
  EXPECT_FALSE(is_granted(on(kOwn + 1)));
  EXPECT_TRUE(is_granted(at(kOther)));
}

TEST_F(AgreementsTest, ThatOfThePublisherCountsForADescribedSubscriber) {
  system_.subscribers.push_back(subscriber(channel_, at(kOther), every(50 * kMs)));
  start();
  EXPECT_FALSE(is_granted(at(kOther)));
  hold(1, {kFirst}, {kOther});
  EXPECT_TRUE(is_granted(at(kOther)));
}

TEST_F(AgreementsTest, AnAgreementOfAnotherGatewayIsNoneOfThatOnTheWay) {
  start();
  hold(1, {kFirst}, {0});
  EXPECT_EQ(towards(on(kOwn + 1)).obstacle, Obstacle::disagreed);
}

TEST_F(AgreementsTest, WithoutTheStoreTheOtherGatewayIsNotTheReason) {
  start();
  hold(1, {kFirst}, {kOther});
  permits().close(false);
  static_cast<void>(state().settle());
  EXPECT_EQ(towards(on(kOwn + 1)).obstacle, Obstacle::cluster);
  EXPECT_EQ(towards(on(kOwn + 1)).obstacle_at, on(kShared));
}

/// What can be given back without a loss.
TEST_F(AgreementsTest, ADeliveryNeedsTheReservationThatAloneHasTheAgreementOrTheCapacity) {
  start();
  const auto needs = [this](std::uint64_t number) {
    return !state().is_permitted_without(towards(on(kOwn + 1)), number);
  };
  hold(1, {kFirst}, {kOther});
  EXPECT_TRUE(needs(1));
  EXPECT_FALSE(needs(2)) << "there is none";
  hold(2, {kFirst}, {kOther});
  EXPECT_FALSE(needs(1));
  EXPECT_FALSE(needs(2));
  hold(2, {kSecond}, {kOther});
  EXPECT_TRUE(needs(1)) << "the other one has the same capacity, and another agreement";
  EXPECT_FALSE(needs(2));
  EXPECT_TRUE(is_granted(on(kOwn + 1))) << "nothing has changed";
}

TEST_F(AgreementsTest, EachWayOverOtherGatewaysIsAWantOfItsOwn) {
  Subscriber here = subscriber(channel_, on(kShared), every(50 * kMs));
  system_.subscribers.push_back(here);
  start();
  const Proposal wish = state().wish(channel_);
  ASSERT_TRUE(wish.fit());
  const auto wants = cluster::wants_of(wish, 0);
  ASSERT_EQ(wants.size(), 2U);
  for (const cluster::Want& want : wants) {
    const auto footprint = cluster::footprint_of(wish, want.deliveries, pair_->baseline, 0);
    EXPECT_EQ(footprint.gateways, want.gateways);
    EXPECT_EQ(want.deliveries.size(), want.gateways.empty() ? 1U : 2U);
    EXPECT_EQ(footprint.parts.size(), 1U) << "the bus of both";
  }
}

TEST_F(AgreementsTest, WhatIsGrantedIsNotWantedAgain) {
  start();
  hold(1, {kFirst}, {kOther});
  const Proposal wish = state().wish(channel_);
  ASSERT_TRUE(wish.fit());
  const auto wants = cluster::wants_of(wish, 0);
  ASSERT_EQ(wants.size(), 1U);
  ASSERT_EQ(wants.front().deliveries.size(), 1U);
  EXPECT_EQ(wants.front().deliveries.front()->to, at(kOther));
}

}  // namespace
}  // namespace mlcca::core::testing
