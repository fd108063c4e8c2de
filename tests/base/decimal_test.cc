// SPDX-License-Identifier: BSD-2-Clause
#include "base/decimal.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "base/units.hpp"

namespace mlcca {
namespace {

constexpr auto kMost = std::numeric_limits<std::uint64_t>::max() - 1;

Decimal decimal(const std::string& text) { return Decimal::read(text).value(); }

TEST(DecimalTest, IsDigitsWithAPointBetween) {
  for (const auto* const text : {"0", "7", "12.5", "0.05", "00.50", "18446744073709551616"})
    EXPECT_TRUE(Decimal::read(text)) << text;
  for (const auto* const text : {"", ".", ".5", "5.", "1.2.3", "-1", "+1", "1e3", "1 ", "0x1"})
    EXPECT_FALSE(Decimal::read(text)) << text;
}

TEST(DecimalTest, IsWrittenAsShortAsCanBe) {
  EXPECT_EQ(decimal("0012.500").text(), "12.5");
  EXPECT_EQ(decimal("0.050").text(), "0.05");
  EXPECT_EQ(decimal("100").text(), "100");
  EXPECT_EQ(decimal("0.000").text(), "0");
  EXPECT_EQ(decimal("3.00").decimals(), 0U);
}

TEST(DecimalTest, IsMultipliedExactly) {
  EXPECT_EQ(decimal("12.5").times(8).text(), "100");
  EXPECT_EQ(decimal("0.001").times(3600).text(), "3.6");
  EXPECT_EQ(decimal("99999999999999999999").times(~std::uint64_t{0}).text(),
            "1844674407370955161481553255926290448385");
  EXPECT_EQ(decimal("5.5").times(0).text(), "0");
}

struct Scaling {
  const char* text;
  int power;
  std::optional<std::uint64_t> down;
  std::optional<std::uint64_t> up;
};

TEST(DecimalTest, IsScaledAndRoundedOnce) {
  for (const auto& [text, power, down, up] : {
           Scaling{"12.5", 3, 12500, 12500},
           Scaling{"12.5", 0, 12, 13},
           Scaling{"0.05", 0, 0, 1},
           Scaling{"0.05", 1, 0, 1},
           Scaling{"0.05", 2, 5, 5},
           Scaling{"1999", -3, 1, 2},
           Scaling{"2000", -3, 2, 2},
           Scaling{"7", -1, 0, 1},
           Scaling{"7", -30, 0, 1},
           Scaling{"0.0", 30, 0, 0},
           Scaling{"18446744073709551614", 0, kMost, kMost},
           Scaling{"18446744073709551614.1", 0, kMost, std::nullopt},
           Scaling{"18446744073709551615", 0, std::nullopt, std::nullopt},
           Scaling{"18446744073709551616", -1, 1844674407370955161, 1844674407370955162},
           Scaling{"1", 19, 10000000000000000000U, 10000000000000000000U},
           Scaling{"1", 20, std::nullopt, std::nullopt},
           Scaling{"0.00000000000000000001", 30, 10000000000, 10000000000},
       }) {
    EXPECT_EQ(decimal(text).scaled(power, false), down) << text << " " << power;
    EXPECT_EQ(decimal(text).scaled(power, true), up) << text << " " << power;
  }
}

TEST(DecimalTest, StandsInFrontOfAUnit) {
  const auto blanks = number_and_unit(" 12.5  kB/s ");
  EXPECT_EQ(blanks.number.value().text(), "12.5");
  EXPECT_EQ(blanks.unit, "kB/s");
  EXPECT_EQ(number_and_unit("5").unit, "");
  EXPECT_FALSE(number_and_unit("ms").number);
  EXPECT_EQ(number_and_unit("ms").unit, "ms");
}

TEST(UnitsTest, AreFactorsOfTheUnitInside) {
  const auto in = [](Measure measure, const char* name, const char* many) {
    return units::find(measure, name)->of(decimal(many), true);
  };
  EXPECT_EQ(in(Measure::nanoseconds, "ms", "12.5"), 12'500'000U);
  EXPECT_EQ(in(Measure::nanoseconds, "h", "0.5"), 1'800'000'000'000U);
  EXPECT_EQ(in(Measure::bytes_per_second, "bit/s", "9"), 2U);
  EXPECT_EQ(in(Measure::bytes_per_second, "MiB/s", "1"), 1'048'576U);
  EXPECT_EQ(in(Measure::bits_per_second, "kB/s", "1"), 8'000U);
  EXPECT_EQ(in(Measure::parts_per_billion, "%", "100"), 1'000'000'000U);
}

TEST(UnitsTest, AreKnownByWhatTheyMeasure) {
  EXPECT_EQ(units::find(Measure::nanoseconds, "B"), nullptr);
  EXPECT_EQ(units::find(Measure::bits_per_second, "M"), nullptr);
  EXPECT_NE(units::find(Measure::bits_per_second, "M", units::kRadioRates), nullptr);
}

}  // namespace
}  // namespace mlcca
