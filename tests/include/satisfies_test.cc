// SPDX-License-Identifier: BSD-2-Clause
// One attribute against one provision: both sides of each bound, the unknown and the best case.
#include "mlcca/satisfies.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace mlcca {
namespace {

class EachAttributeTest : public ::testing::TestWithParam<std::size_t> {
 protected:
  static Attribute attribute() { return attribute_at(GetParam()); }
  static AttributeSet provision(Value v, bool dynamic = false) {
    return AttributeSet().set(held_against(attribute()), v, dynamic);
  }
  /// `by` units better (worse if negative) than 1000.
  static Value changed(std::int64_t by) {
    return static_cast<Value>(info(attribute()).better == Better::smaller ? 1000 - by : 1000 + by);
  }
};

TEST_P(EachAttributeTest, BoundIsMetExactlyAndMissedByOne) {
  EXPECT_EQ(compare(attribute(), 1000, provision(changed(1))).outcome, Outcome::fit);
  EXPECT_EQ(compare(attribute(), 1000, provision(1000)).outcome, Outcome::fit);
  EXPECT_EQ(compare(attribute(), 1000, provision(changed(-1))).outcome, Outcome::unfit);
}

TEST_P(EachAttributeTest, BestCaseRefutesButNeverGrants) {
  EXPECT_EQ(compare(attribute(), 1000, provision(changed(1), true)).outcome, Outcome::run_time);
  EXPECT_EQ(compare(attribute(), 1000, provision(1000, true)).outcome, Outcome::run_time);
  EXPECT_EQ(compare(attribute(), 1000, provision(changed(-1), true)).outcome, Outcome::unfit);
  EXPECT_TRUE(compare(attribute(), 1000, provision(1000, true)).dynamic);
}

TEST_P(EachAttributeTest, MissingProvisionIsUnfitWhateverIsRequired) {
  AttributeSet all_others;
  for (std::size_t i = 0; i < kAttributes; ++i)
    all_others.set(attribute_at(i), info(attribute_at(i)).better == Better::smaller ? 0 : 1000);
  all_others.clear(held_against(attribute()));
  for (const Value required : {Value{0}, Value{1}, kUnbounded}) {
    const Comparison row = compare(attribute(), required, all_others);
    EXPECT_EQ(row.outcome, Outcome::unfit);
    EXPECT_FALSE(row.known);
    EXPECT_EQ(row.provided, 0U);
    EXPECT_EQ(row.margin(), 0U);
  }
}

TEST_P(EachAttributeTest, MarginIsTheDistanceOnBothSides) {
  EXPECT_EQ(compare(attribute(), 1000, provision(997)).margin(), 3U);
  EXPECT_EQ(compare(attribute(), 1000, provision(1003)).margin(), 3U);
  EXPECT_EQ(compare(attribute(), 0, provision(kUnbounded)).margin(), kUnbounded);
}

INSTANTIATE_TEST_SUITE_P(Table, EachAttributeTest, ::testing::Range(std::size_t{0}, kAttributes),
                         [](const auto& row) { return mlcca::info(attribute_at(row.param)).name; });

TEST(SatisfiesTest, DeadlineIsHeldAgainstLatency) {
  AttributeSet provision;
  provision.set(Attribute::deadline, 1);
  EXPECT_EQ(compare(Attribute::deadline, 10, provision).outcome, Outcome::unfit);
  provision.set(Attribute::latency, 9);
  const Comparison row = compare(Attribute::deadline, 10, provision);
  EXPECT_EQ(row.outcome, Outcome::fit);
  EXPECT_EQ(row.attribute, Attribute::deadline);
  EXPECT_EQ(row.provided, 9U);
}

TEST(SatisfiesTest, NoBoundSatisfiesNothingButNoBound) {
  const AttributeSet provision = AttributeSet().set(Attribute::omission, kUnbounded);
  EXPECT_EQ(compare(Attribute::omission, kUnbounded - 1, provision).outcome, Outcome::unfit);
  EXPECT_EQ(compare(Attribute::omission, kUnbounded, provision).outcome, Outcome::fit);
}

TEST(SatisfiesTest, WorseIsCommutativeAndUnfitDominates) {
  constexpr Outcome order[] = {Outcome::fit, Outcome::run_time, Outcome::unfit};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(worse(order[i], order[j]), order[std::max(i, j)]);
}

TEST(SatisfiesTest, AtRunTimeABestCaseThatNothingReplacedIsRefused) {
  EXPECT_EQ(at_run_time(Outcome::run_time), Outcome::unfit);
  EXPECT_EQ(at_run_time(Outcome::unfit), Outcome::unfit);
  EXPECT_EQ(at_run_time(Outcome::fit), Outcome::fit);
}

}  // namespace
}  // namespace mlcca
