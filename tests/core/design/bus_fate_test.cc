// SPDX-License-Identifier: BSD-2-Clause
// One verdict and one time for each message of a bus.
#include "core/design/bus_fate.hpp"

#include <gtest/gtest.h>

namespace mlcca::core::testing {
namespace {

constexpr can::Time kDeadline = 1000;

can::Message with_jitter(can::Time jitter) {
  can::Message message;
  message.deadline = kDeadline;
  message.jitter = jitter;
  return message;
}

can::Response taking(can::Time time) {
  can::Response response;
  response.bounded = true;
  response.response = time;
  response.queued_frames = 2;
  return response;
}

BusRow row_of(const BusDecision& decision, const can::Response& response) {
  return core::row_of(decision, {}, with_jitter(300), response);
}

TEST(BusFateTest, WhatCountsHasTheTimeBesideAllThatCounts) {
  const BusRow met = row_of({}, taking(900));
  EXPECT_EQ(met.fate, BusFate::met);
  EXPECT_EQ(met.response, 900U);
  EXPECT_EQ(met.jitter, 300U);
  EXPECT_EQ(met.frames, 2U);
  EXPECT_EQ(row_of({}, taking(1001)).fate, BusFate::late);
  const BusRow unbounded = row_of({}, {});
  EXPECT_EQ(unbounded.fate, BusFate::not_bounded);
  EXPECT_EQ(unbounded.response, can::kNever);
  EXPECT_FALSE(unbounded.frames);
}

TEST(BusFateTest, WhatIsSentThoughItIsRefusedHasThatTimeToo) {
  const BusDecision own{.outcome = Outcome::unfit, .held = false, .refused_response = 1100};
  const BusRow late = row_of(own, taking(1200));
  EXPECT_EQ(late.fate, BusFate::late);
  EXPECT_EQ(late.response, 1200U);
  const BusDecision other{.outcome = Outcome::unfit, .held = false};
  EXPECT_EQ(row_of(other, taking(1200)).fate, BusFate::late);
  EXPECT_EQ(row_of(other, taking(900)).fate, BusFate::refused);
  const BusDecision in_vain{.outcome = Outcome::unfit, .held = false, .in_vain = true};
  EXPECT_EQ(row_of(in_vain, taking(900)).fate, BusFate::refused_for_others);
}

TEST(BusFateTest, WhatIsDroppedBeforeTheBusHasTheTimeThatItIsRefusedForOrNone) {
  BusDecision dropped{.outcome = Outcome::unfit, .held = false, .counted = false};
  EXPECT_EQ(row_of(dropped, taking(1200)).fate, BusFate::refused);
  EXPECT_FALSE(row_of(dropped, taking(1200)).response);
  EXPECT_FALSE(row_of(dropped, taking(1200)).frames);
  dropped.in_vain = true;
  EXPECT_EQ(row_of(dropped, taking(1200)).fate, BusFate::refused_for_others);
  dropped.refused_frames = 4;
  EXPECT_EQ(row_of(dropped, taking(900)).fate, BusFate::queue_too_short);
  EXPECT_EQ(row_of(dropped, taking(900)).frames, 4U);
  dropped.refused_response = 1100;
  dropped.refused_jitter = 200;
  EXPECT_EQ(row_of(dropped, taking(1200)).fate, BusFate::late);
  EXPECT_EQ(row_of(dropped, taking(1200)).response, 1100U);
  EXPECT_EQ(row_of(dropped, taking(1200)).jitter, 200U) << "that is in it";
  dropped.refused_response = can::kNever;
  EXPECT_EQ(row_of(dropped, taking(1200)).fate, BusFate::not_bounded);
}

TEST(BusFateTest, WhatCompetesIsDecidedAtRunTimeHoweverLateItWouldBe) {
  const BusDecision contested{.outcome = Outcome::run_time, .held = false};
  EXPECT_EQ(row_of(contested, taking(1200)).fate, BusFate::run_time);
  const BusDecision at_best{.outcome = Outcome::run_time};
  EXPECT_EQ(row_of(at_best, taking(900)).fate, BusFate::met);
}

}  // namespace
}  // namespace mlcca::core::testing
