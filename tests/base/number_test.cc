// SPDX-License-Identifier: BSD-2-Clause
#include "base/number.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>

namespace mlcca {
namespace {

TEST(NumberTest, IsTheWholeText) {
  EXPECT_EQ(number_in<std::uint16_t>("65535"), 65535);
  EXPECT_EQ(number_in<int>("-12"), -12);
  EXPECT_EQ(number_in<std::uint32_t>("ff", kHexadecimalBase), 255U);
  for (const auto* const text : {"", " 1", "1 ", "+1", "1x", "0x1", "x"})
    EXPECT_EQ(number_in<std::uint16_t>(text), std::nullopt) << text;
}

TEST(NumberTest, MustFit) {
  EXPECT_EQ(number_in<std::uint16_t>("65536"), std::nullopt);
  EXPECT_EQ(number_in<std::uint16_t>("-1"), std::nullopt);
  EXPECT_EQ(number_in<std::uint64_t>("18446744073709551615"), ~std::uint64_t{0});
  EXPECT_EQ(number_in<std::uint64_t>("18446744073709551616"), std::nullopt);
}

TEST(NumberTest, IsHexadecimalBehindItsPrefix) {
  EXPECT_EQ(prefixed_number_in<std::uint32_t>("0x1f"), 31U);
  EXPECT_EQ(prefixed_number_in<std::uint32_t>("31"), 31U);
  EXPECT_EQ(prefixed_number_in<std::uint32_t>("0x"), std::nullopt);
  EXPECT_EQ(prefixed_number_in<std::uint32_t>("1f"), std::nullopt);
}

TEST(NumberTest, IsTakenOffTheFront) {
  std::string_view text = "12ms";
  EXPECT_EQ(take_number<unsigned>(text), 12U);
  EXPECT_EQ(text, "ms");
  EXPECT_EQ(take_number<unsigned>(text), std::nullopt);
  EXPECT_EQ(text, "ms");
}

TEST(NumberTest, IsWrittenInHexadecimal) {
  EXPECT_EQ(hexadecimal(0U), "0x0");
  EXPECT_EQ(hexadecimal(std::uint8_t{255}), "0xff");
  EXPECT_EQ(hexadecimal(~std::uint64_t{0}), "0xffffffffffffffff");
}

}  // namespace
}  // namespace mlcca
