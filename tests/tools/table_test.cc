// SPDX-License-Identifier: BSD-2-Clause
#include "tools/table.hpp"

#include <gtest/gtest.h>

namespace mlcca::tools {
namespace {

TEST(TableTest, IsAsWideAsItsContent) {
  TextTable table({{"NAME"}, {"N", Align::right}, {"WHY"}});
  table.add({{"a"}, {"7"}, {"x"}});
  table.add({{"longer"}, {"1234"}, {""}});
  EXPECT_EQ(table.text(Color::no, "  "),
            "  NAME       N  WHY\n"
            "  a          7  x\n"
            "  longer  1234\n");
}

TEST(TableTest, LeavesOutColumnsWithoutContent) {
  TextTable table({{"NAME"}, {"EMPTY"}, {"N", Align::right}});
  table.add({{"a"}, {""}, {"1"}});
  EXPECT_EQ(table.text(Color::no), "NAME  N\na     1\n");
}

TEST(TableTest, WithoutRowsIsNothing) {
  const TextTable table({{"NAME"}});
  EXPECT_TRUE(table.empty());
  EXPECT_EQ(table.text(Color::no), "");
}

TEST(TableTest, AlignsCharactersNotBytes) {
  TextTable table({{"NAME"}, {"N"}});
  table.add({{"fünf"}, {"1"}});
  table.add({{"five"}, {"2"}});
  EXPECT_EQ(table.text(Color::no), "NAME  N\nfünf  1\nfive  2\n");
}

TEST(TableTest, ColoursTextAndNotPadding) {
  TextTable table({{"V"}, {"N", Align::right}});
  table.add({{"granted", Style::good}, {"1", Style::bad}});
  table.add({{"no"}, {"22"}});
  EXPECT_EQ(table.text(Color::yes),
            "\x1b[1mV\x1b[0m         \x1b[1mN\x1b[0m\n"
            "\x1b[32mgranted\x1b[0m   \x1b[1;31m1\x1b[0m\n"
            "no       22\n");
}

TEST(TableTest, LetsNoContentSteerTheTerminal) {
  EXPECT_EQ(printable("a\x1b[2Jb\n\x7f"), "a?[2Jb??");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "?31m");  // CSI as one character
  EXPECT_EQ(printable("\xc2\xb5s ü"), "µs ü");
  EXPECT_EQ(styled("\x1b", Style::bad, Color::no), "?");
  TextTable table({{"NAME"}, {"N"}});
  table.add({{"\x1b[2J"}, {"1"}});
  EXPECT_EQ(table.text(Color::no), "NAME  N\n?[2J  1\n");
}

}  // namespace
}  // namespace mlcca::tools
