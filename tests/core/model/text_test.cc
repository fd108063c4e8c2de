// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/text.hpp"

#include <gtest/gtest.h>

namespace mlcca::core {
namespace {

TEST(Text, SpansHaveTheirTwoLargestUnits) {
  constexpr Value kSecond = 1'000'000'000;
  EXPECT_EQ(format_span(0), "0 s");
  EXPECT_EQ(format_span(4 * kSecond + 999'999'999), "4 s");
  EXPECT_EQ(format_span(59 * kSecond), "59 s");
  EXPECT_EQ(format_span(60 * kSecond), "1 min");
  EXPECT_EQ(format_span(200 * kSecond), "3 min 20 s");
  EXPECT_EQ(format_span(3600 * kSecond + 59 * kSecond), "1 h");
  EXPECT_EQ(format_span(86'400 * kSecond), "1 d");
  EXPECT_EQ(format_span(94'000 * kSecond), "1 d 2 h");
}

TEST(TextTest, WritesValuesWithTheUnitAPersonWouldUse) {
  EXPECT_EQ(format_value(Attribute::period, 50'000'000), "50 ms");
  EXPECT_EQ(format_value(Attribute::latency, 1'500), "1.5 us");
  EXPECT_EQ(format_value(Attribute::latency, 999), "999 ns");
  EXPECT_EQ(format_value(Attribute::latency, 0), "0 ns");
  EXPECT_EQ(format_value(Attribute::latency, 2'000'000'001), "2 s");
  EXPECT_EQ(format_value(Attribute::latency, 1'999'999'999), "2 s");
  EXPECT_EQ(format_value(Attribute::bandwidth, 400'000), "400 kB/s");
  EXPECT_EQ(format_value(Attribute::bandwidth, 942'857), "942.857 kB/s");
  EXPECT_EQ(format_value(Attribute::packet_loss, 5'000'000), "0.5 %");
  EXPECT_EQ(format_value(Attribute::packet_loss, 1), "0.0000001 %");
  EXPECT_EQ(format_value(Attribute::packet_loss, kCertainLoss), "100 %");
  EXPECT_EQ(format_value(Attribute::omission, 2), "2");
  EXPECT_EQ(format_value(Attribute::omission, kUnbounded), "unbounded");
  EXPECT_EQ(format_value(Attribute::max_payload, 8), "8 bytes");
}

TEST(TextTest, ABoundIsPrintedOtherwiseThanALimitThatItIsNot) {
  const auto words = [](Attribute a, Value bound, Value limit) {
    const BoundWords both = format_bound(a, bound, limit);
    return both.bound + " of " + both.limit;
  };
  EXPECT_EQ(words(Attribute::latency, 8'000'000, 10'000'000), "8 ms of 10 ms");
  EXPECT_EQ(words(Attribute::latency, 10'000'400, 10'000'000), "10.0004 ms of 10 ms");
  EXPECT_EQ(words(Attribute::latency, 10'000'000, 9'999'999), "10 ms of 9.999999 ms");
  EXPECT_EQ(words(Attribute::latency, 1'000'000'000, 999'999'999), "1 s of 999.999999 ms");
  EXPECT_EQ(words(Attribute::latency, 10'000'400, 10'000'400), "10 ms of 10 ms");
  EXPECT_EQ(words(Attribute::latency, kUnbounded, 10'000'400), "unbounded of 10 ms");
  EXPECT_EQ(words(Attribute::bandwidth, 400'000'001, 400'000'000), "400.000001 MB/s of 400 MB/s");
  EXPECT_EQ(words(Attribute::omission, 3, 2), "3 of 2");
  EXPECT_EQ(words(Attribute::latency, 0, 1), "0 ns of 1 ns");
}

TEST(TextTest, WritesMarginsInWords) {
  const auto margin = [](Attribute a, Value required, Value provided) {
    return format_margin(compare(a, required, AttributeSet{}.set(a, provided)));
  };
  EXPECT_EQ(margin(Attribute::omission, 2, 5), "3 too many");
  EXPECT_EQ(margin(Attribute::omission, 2, 2), "exactly met");
  EXPECT_EQ(margin(Attribute::latency, 50'000'000, 37'500'000), "12.5 ms to spare");
  EXPECT_EQ(margin(Attribute::bandwidth, 400, 100), "300 B/s short");
  EXPECT_EQ(format_margin(compare(Attribute::omission, 2, AttributeSet{})), "not provided");
}

TEST(TextTest, WritesMarginsThatHaveNoEndInWords) {
  const auto margin = [](Attribute a, Value required, Value provided) {
    return format_margin(compare(a, required, AttributeSet{}.set(a, provided)));
  };
  EXPECT_EQ(margin(Attribute::max_payload, 8, kUnbounded), "no limit");
  EXPECT_EQ(margin(Attribute::latency, 8, kUnbounded), "unbounded");
  EXPECT_EQ(margin(Attribute::latency, 8, 10), "2 ns too long");
}

UserAttribute own(int magnitude, const char* unit, Better better = Better::smaller) {
  UserAttribute a;
  a.name = "Own";
  a.magnitude = magnitude;
  a.unit = unit;
  a.better = better;
  return a;
}

TEST(TextTest, WritesUserDefinedValuesAsTheDescriptionDoes) {
  EXPECT_EQ(format_user_value(own(0, "K"), 215), "215 K");
  EXPECT_EQ(format_user_value(own(0, ""), 215), "215");
  EXPECT_EQ(format_user_value(own(2, "K"), 215), "21500 K");
  EXPECT_EQ(format_user_value(own(2, "K"), 0), "0 K");
  EXPECT_EQ(format_user_value(own(-1, "K"), 215), "21.5 K");
  EXPECT_EQ(format_user_value(own(-1, "K"), 210), "21 K");
  EXPECT_EQ(format_user_value(own(-1, "K"), 200), "20 K");
  EXPECT_EQ(format_user_value(own(-3, "K"), 215), "0.215 K");
  EXPECT_EQ(format_user_value(own(-3, "K"), 5), "0.005 K");
  EXPECT_EQ(format_user_value(own(-3, "K"), 10), "0.01 K");
  EXPECT_EQ(format_user_value(own(-3, "K"), 0), "0 K");
  EXPECT_EQ(format_user_value(own(-3, "K"), 1000), "1 K");
  EXPECT_EQ(format_user_value(own(-3, "K"), kUnbounded), "unbounded");
}

TEST(TextTest, WritesMarginsOfUserDefinedValues) {
  System system;
  system.user_attributes = {own(-1, "K"), own(0, "", Better::larger), own(3, "m"), own(3, "")};
  const auto margin = [&](std::uint32_t attribute, Value required, Value provided,
                          bool known = true) {
    Row row;
    row.user = attribute;
    row.comparison.known = known;
    row.comparison.required = required;
    row.comparison.provided = provided;
    return format_margin(system, row);
  };
  EXPECT_EQ(margin(0, 30, 30), "exactly met");
  EXPECT_EQ(margin(0, 30, 25), "0.5 K to spare");
  EXPECT_EQ(margin(0, 30, 45), "1.5 K too much");
  EXPECT_EQ(margin(1, 30, 45), "15 to spare");
  EXPECT_EQ(margin(1, 30, 25), "5 short");
  EXPECT_EQ(margin(1, kUnbounded, 25), "unbounded");
  EXPECT_EQ(margin(0, 30, kUnbounded), "unbounded");
  EXPECT_EQ(margin(0, 30, 0, false), "not provided");
  Row row;
  row.user = 0;
  EXPECT_EQ(unit_name(system, row), "1e-1 K");
  row.user = 1;
  EXPECT_EQ(unit_name(system, row), "");
  row.user = 2;
  EXPECT_EQ(unit_name(system, row), "1e3 m");
  row.user = 3;
  EXPECT_EQ(unit_name(system, row), "1e3");
  EXPECT_EQ(attribute_name(system, row), "Own");
  EXPECT_EQ(format_value(system, row, 2), "2000");
}

TEST(TextTest, WritesSubjectsWithAllDigits) {
  EXPECT_EQ(format_subject(0xa4efeccc3210b497), "0xa4efeccc3210b497");
  EXPECT_EQ(format_subject(1), "0x0000000000000001");
}

TEST(TextTest, NamesSeveralPublishers) {
  System system;
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    Publisher p;
    p.name = name;
    system.publishers.push_back(p);
  }
  system.channels.emplace_back();
  const Members members(system);
  EXPECT_EQ(names_of(members, {0}), "a");
  EXPECT_EQ(names_of(members, {0, 1}), "a and b");
  EXPECT_EQ(names_of(members, {0, 1, 2, 3}), "a, b, c and d");
  EXPECT_EQ(names_of(members, {0, 1, 2, 3, 4}), "a, b, c and 2 more");
}

}  // namespace
}  // namespace mlcca::core
