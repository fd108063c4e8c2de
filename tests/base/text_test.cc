// SPDX-License-Identifier: BSD-2-Clause
#include "base/text.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>

namespace mlcca {
namespace {

TEST(Text, IsCutAfterACompleteCharacter) {
  EXPECT_EQ(cut("abc", 3), "abc");
  EXPECT_EQ(cut("abcd", 3), "abc");
  EXPECT_EQ(cut("ab\u00e9", 3), "ab");
  EXPECT_EQ(cut("ab\u00e9", 4), "ab\u00e9");
  EXPECT_EQ(cut("a\u20acb", 4), "a\u20ac");
  EXPECT_EQ(cut("a\u20acb", 3), "a");
  EXPECT_EQ(cut("a\u20acb", 2), "a");
  for (const std::size_t most : {1U, 2U, 3U}) EXPECT_EQ(cut("\U0001f512", most), "") << most;
  EXPECT_EQ(cut("\U0001f512x", 4), "\U0001f512");
  EXPECT_EQ(cut("x", 0), "");
}

TEST(Text, IsCutWhereItIsNoUtf8AtAll) {
  EXPECT_EQ(cut(std::string(20, '\x80'), 10).size(), 10U);
  EXPECT_EQ(cut(std::string(20, '\xff'), 10).size(), 10U);
}

TEST(Text, HasNoControlCharactersInALog) {
  EXPECT_EQ(printable("a\nb\x1b[1m\x7f\u20ac", 64), "a?b?[1m?\u20ac");
  EXPECT_EQ(printable("\u20ac\u20ac", 5), "\u20ac");
}

}  // namespace
}  // namespace mlcca
