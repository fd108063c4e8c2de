// SPDX-License-Identifier: BSD-2-Clause
// Quantities keep their units apart. What must not compile is in refused/, see `make check-mcu`.
#include "mlcca/units.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace mlcca {
namespace {

static_assert(std::is_constructible_v<Period, Nanoseconds>);
static_assert(!std::is_constructible_v<Period, Bytes>);
static_assert(!std::is_constructible_v<Period, Value>);
static_assert(!std::is_constructible_v<Bandwidth, Bytes>);
static_assert(!std::is_convertible_v<Value, Nanoseconds>);
static_assert(!std::is_constructible_v<Bytes, Nanoseconds>);

TEST(UnitsTest, LiteralsCountInTheUnitOfTheTable) {
  EXPECT_EQ((1_s).count, 1000000000U);
  EXPECT_EQ(1_s, 1000_ms);
  EXPECT_EQ(1_ms, 1000_us);
  EXPECT_EQ(1_us, 1000_ns);
  EXPECT_EQ((8_bytes).count, 8U);
  EXPECT_EQ(1_kB_per_s, 1000_bytes_per_s);
  EXPECT_EQ(1_kbit_per_s, 125_bytes_per_s);
  EXPECT_EQ(1_Mbit_per_s, 1000_kbit_per_s);
  EXPECT_EQ((100_percent).count, kCertainLoss);
  EXPECT_EQ(1_percent, 10000_ppm);
  EXPECT_EQ(1_ppm, 1000_ppb);
  EXPECT_EQ(0_ns, Nanoseconds());
}

TEST(UnitsTest, SumsOfQuantitiesSaturate) {
  EXPECT_EQ(1_ms + 1_us, 1001_us);
  EXPECT_EQ(Nanoseconds(kUnbounded - 1) + 2_ns, Nanoseconds(kUnbounded));
  EXPECT_LT(1_ms, 2_ms);
  EXPECT_GE(2_ms, 2_ms);
}

TEST(UnitsTest, EachTypedAttributeSetsItsOwnEntry) {
  const AttributeSet set =
      make_set(Latency{1_ns}, Jitter{2_ns}, Deadline{3_ns}, Period{4_ns}, Bandwidth{5_bytes_per_s},
               PacketLoss{6_ppb}, Omission{7_events}, MaxPayload{8_bytes});
  for (std::size_t i = 0; i < kAttributes; ++i) {
    EXPECT_TRUE(set.has(attribute_at(i)));
    EXPECT_FALSE(set.is_dynamic(attribute_at(i)));
    EXPECT_EQ(set[attribute_at(i)], i + 1);
  }
}

TEST(UnitsTest, AssignMarksABestCase) {
  AttributeSet set;
  assign(set, Bandwidth{24_Mbit_per_s}, true);
  EXPECT_TRUE(set.is_dynamic(Attribute::bandwidth));
  EXPECT_EQ(set[Attribute::bandwidth], 3000000U);
  assign(set, Bandwidth{11_Mbit_per_s});
  EXPECT_FALSE(set.is_dynamic(Attribute::bandwidth));
}

}  // namespace
}  // namespace mlcca
