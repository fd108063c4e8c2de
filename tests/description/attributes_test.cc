// SPDX-License-Identifier: BSD-2-Clause
// Units and rounding: exact where it can be, else to the safe side, never past 64 bits.
#include "description/attributes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace mlcca::description {
namespace {

constexpr Dimension kSeconds{.unit = {1, 0}, .magnitude = 0};
constexpr Dimension kNanoseconds{.unit = {1, 0}, .magnitude = -9};
constexpr Dimension kRate{.unit = {-1, 1}, .magnitude = 0};
constexpr Dimension kBytes{.unit = {0, 1}, .magnitude = 0};
constexpr Dimension kPlain{};

struct Row {
  std::string name;
  Attribute attribute;
  std::string decimal;
  Dimension dimension;
  Value requirement;
  Value provision;
};

class Rounding : public ::testing::TestWithParam<Row> {};

TEST_P(Rounding, GoesToHarderForRequirementsAndToWorseForProvisions) {
  const auto& r = GetParam();
  EXPECT_EQ(to_value(r.attribute, r.decimal, r.dimension, Side::requirement), r.requirement);
  EXPECT_EQ(to_value(r.attribute, r.decimal, r.dimension, Side::provision), r.provision);
}

constexpr Dimension times(Dimension d, int magnitude) {
  d.magnitude = magnitude;
  return d;
}

INSTANTIATE_TEST_SUITE_P(
    Values, Rounding,
    ::testing::Values(
        Row{"milliseconds", Attribute::latency, "50", times(kSeconds, -3), 50000000, 50000000},
        Row{"whole_from_fraction", Attribute::period, "0.050", kSeconds, 50000000, 50000000},
        Row{"trailing_zeros_are_exact", Attribute::latency, "1.000", kNanoseconds, 1, 1},
        Row{"part_of_a_nanosecond", Attribute::latency, "1.5", kNanoseconds, 1, 2},
        Row{"least_part", Attribute::latency, "2.00000000000000000001", kNanoseconds, 2, 3},
        Row{"below_a_nanosecond", Attribute::latency, "1", times(kSeconds, -30), 0, 1},
        Row{"zero_at_any_power", Attribute::latency, "0", times(kSeconds, 30), 0, 0},
        Row{"leading_zeros", Attribute::latency, "00000000000000000001", kNanoseconds, 1, 1},
        Row{"rate", Attribute::bandwidth, "3.5", kRate, 4, 3},
        Row{"rate_below_one", Attribute::bandwidth, "0.5", kRate, 1, 0},
        Row{"kilobytes", Attribute::bandwidth, "400", times(kRate, 3), 400000, 400000},
        Row{"size", Attribute::max_payload, "7.1", kBytes, 8, 7},
        Row{"per_mille", Attribute::packet_loss, "5", times(kPlain, -3), 5000000, 5000000},
        Row{"loss_below_a_unit", Attribute::packet_loss, "1", times(kPlain, -10), 0, 1},
        Row{"certain_loss", Attribute::packet_loss, "1", kPlain, kCertainLoss, kCertainLoss},
        Row{"events", Attribute::omission, "2", kPlain, 2, 2},
        Row{"events_by_power", Attribute::omission, "2", times(kPlain, 1), 20, 20},
        Row{"largest", Attribute::omission, "18446744073709551614", kPlain, kUnbounded - 1,
            kUnbounded - 1},
        Row{"largest_by_fraction", Attribute::omission, "18446744073709551613.5", kPlain,
            kUnbounded - 2, kUnbounded - 1}),
    [](const auto& row) { return row.param.name; });

TEST(ToValue, RefusesWhatNeedsMoreThan64Bits) {
  for (const auto side : {Side::requirement, Side::provision}) {
    EXPECT_FALSE(to_value(Attribute::omission, "18446744073709551615", kPlain, side));
    EXPECT_FALSE(to_value(Attribute::omission, "99999999999999999999", times(kPlain, 30), side));
    EXPECT_FALSE(to_value(Attribute::latency, "18446744074", kSeconds, side));
  }
}

TEST(ToValue, RefusesToRoundUpIntoTheValueOfNoBound) {
  EXPECT_FALSE(to_value(Attribute::omission, "18446744073709551614.5", kPlain, Side::provision));
  EXPECT_TRUE(to_value(Attribute::omission, "18446744073709551614.5", kPlain, Side::requirement));
}

TEST(ToValue, RefusesALossAboveOneAfterRounding) {
  EXPECT_FALSE(to_value(Attribute::packet_loss, "1.0000000001", kPlain, Side::provision));
  EXPECT_EQ(to_value(Attribute::packet_loss, "0.9999999999", kPlain, Side::provision),
            kCertainLoss);
}

TEST(ToValue, RefusesAPeriodOrDeadlineThatRoundsToNothing) {
  EXPECT_FALSE(to_value(Attribute::period, "0.9", kNanoseconds, Side::requirement));
  EXPECT_EQ(to_value(Attribute::period, "1", kNanoseconds, Side::requirement), 1U);
  EXPECT_EQ(to_value(Attribute::period, "0.9", kNanoseconds, Side::provision), 1U);
  EXPECT_FALSE(to_value(Attribute::deadline, "0", kSeconds, Side::requirement));
}

TEST(ToValue, RefusesAProvidedDeadline) {
  EXPECT_FALSE(to_value(Attribute::deadline, "1", kSeconds, Side::provision));
  EXPECT_EQ(to_value(Attribute::deadline, "1", kNanoseconds, Side::requirement), 1U);
}

TEST(ToValue, AcceptsEachAttributeInOneDimensionOnly) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    int accepted = 0;
    for (const int seconds : {-2, -1, 0, 1, 2})
      for (const int bytes : {-1, 0, 1, 2}) {
        const Dimension d{
            .unit = {static_cast<std::int8_t>(seconds), static_cast<std::int8_t>(bytes)},
            .magnitude = 0};
        if (to_value(attribute_at(i), "1", d, Side::requirement)) ++accepted;
      }
    EXPECT_EQ(accepted, 1) << info(attribute_at(i)).name;
  }
}

// Requirements never get easier nor provisions better than what stands there, whatever the digits.
TEST(ToValue, IsNeverOnTheUnsafeSideOfTheExactValue) {
  for (int thousandths = 0; thousandths < 3000; ++thousandths) {
    std::string fraction = std::to_string(thousandths % 1000);
    fraction.insert(0, 3 - fraction.size(), '0');
    const auto text = std::to_string(thousandths / 1000) + "." + fraction;
    const auto floor = static_cast<Value>(thousandths / 1000);
    const auto ceiling = static_cast<Value>((thousandths + 999) / 1000);
    EXPECT_EQ(to_value(Attribute::jitter, text, kNanoseconds, Side::requirement), floor) << text;
    EXPECT_EQ(to_value(Attribute::jitter, text, kNanoseconds, Side::provision), ceiling) << text;
    EXPECT_EQ(to_value(Attribute::bandwidth, text, kRate, Side::requirement), ceiling) << text;
    EXPECT_EQ(to_value(Attribute::bandwidth, text, kRate, Side::provision), floor) << text;
  }
}

TEST(WithOwn, ReplacesByNameAndKeepsTheRest) {
  AttributeSet defaults;
  defaults.set(Attribute::omission, 2).set(Attribute::period, 50);
  AttributeSet own;
  own.set(Attribute::omission, 0).set(Attribute::jitter, 7);
  AttributeSet expected;
  expected.set(Attribute::omission, 0).set(Attribute::period, 50).set(Attribute::jitter, 7);
  EXPECT_EQ(with_own(defaults, own), expected);
  EXPECT_EQ(with_own(defaults, {}), defaults);
}

}  // namespace
}  // namespace mlcca::description
