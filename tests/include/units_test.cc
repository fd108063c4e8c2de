// SPDX-License-Identifier: BSD-2-Clause
// Quantities keep their units apart. What must not compile is in tests/include/compile/refused/.
#include "mlcca/units.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace mlcca {
namespace {

static_assert(!std::is_convertible_v<Value, Nanoseconds>);
static_assert(!std::is_convertible_v<Nanoseconds, Value>);
static_assert(!std::is_convertible_v<Bytes, Nanoseconds>);
static_assert(!std::is_convertible_v<Bytes, BytesPerSecond>);

TEST(UnitsTest, LiteralsCountInTheUnitOfTheTable) {
  EXPECT_EQ(count(1_s), 1000000000U);
  EXPECT_EQ(1_s, 1000_ms);
  EXPECT_EQ(1_ms, 1000_us);
  EXPECT_EQ(1_us, 1000_ns);
  EXPECT_EQ(count(8_bytes), 8U);
  EXPECT_EQ(1_kB_per_s, 1000_bytes_per_s);
  EXPECT_EQ(1_kbit_per_s, 125_bytes_per_s);
  EXPECT_EQ(1_Mbit_per_s, 1000_kbit_per_s);
  EXPECT_EQ(count(100_percent), kCertainLoss);
  EXPECT_EQ(1_percent, 10000_ppm);
  EXPECT_EQ(1_ppm, 1000_ppb);
  EXPECT_EQ(count(0_ns), 0U);
}

TEST(UnitsTest, SumsOfTimesSaturate) {
  EXPECT_EQ(1_ms + 1_us, 1001_us);
  EXPECT_EQ(Nanoseconds(kUnbounded - 1) + 2_ns, Nanoseconds(kUnbounded));
  EXPECT_LT(1_ms, 2_ms);
  EXPECT_GE(2_ms, 2_ms);
}

TEST(UnitsTest, DigitsMayBeSeparated) {
  EXPECT_EQ(1'000'000_ns, 1_ms);
  EXPECT_EQ(18'446'744'073_s, Nanoseconds(18446744073000000000U));
}

}  // namespace
}  // namespace mlcca
