// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/text.hpp"

#include <gtest/gtest.h>

namespace mlcca::core {
namespace {

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

TEST(TextTest, WritesSubjectsWithAllDigits) {
  EXPECT_EQ(format_subject(0xa4efeccc3210b497), "0xa4efeccc3210b497");
  EXPECT_EQ(format_subject(1), "0x0000000000000001");
}

}  // namespace
}  // namespace mlcca::core
