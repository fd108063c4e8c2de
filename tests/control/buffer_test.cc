// SPDX-License-Identifier: BSD-2-Clause
#include "control/buffer.hpp"

#include <gtest/gtest.h>

#include <string>

#include "control/utf8.hpp"

namespace mlcca::control {
namespace {

TEST(BufferTest, GivesBackWhatWasPutInInAnyPieces) {
  Buffer buffer;
  std::string expected;
  for (int i = 0; i < 1000; ++i) {
    const std::string piece(static_cast<std::size_t>(i % 97), static_cast<char>('a' + i % 26));
    buffer.append(piece);
    expected += piece;
    const auto taken = std::min<std::size_t>(expected.size(), static_cast<std::size_t>(i % 71));
    ASSERT_EQ(buffer.content().substr(0, taken), expected.substr(0, taken));
    buffer.consume(taken);
    expected.erase(0, taken);
    ASSERT_EQ(buffer.content(), expected);
  }
}

TEST(BufferTest, HasAtLeastTheRoomThatWasAskedFor) {
  Buffer buffer;
  for (const std::size_t n : {1UL, 4096UL, 4097UL, 100'000UL}) {
    EXPECT_GE(buffer.space(n).size(), n);
    buffer.append("some");
  }
}

TEST(BufferTest, MovesAGrowingMessageOnlyEachTimeItDoubles) {
  Buffer buffer;
  const std::string piece(4096, 'a');
  const char* place = nullptr;
  int moves = 0;
  for (int i = 0; i < 4096; ++i) {  // 16 MiB
    buffer.append(piece);
    moves += buffer.content().data() != place ? 1 : 0;
    place = buffer.content().data();
  }
  EXPECT_EQ(buffer.content().size(), 16UL * 1024 * 1024);
  EXPECT_LE(moves, 14);
}

TEST(BufferTest, DoesNotGrowUnderAStreamOfSmallMessages) {
  Buffer buffer;
  buffer.append(std::string(100, 'a'));
  for (int i = 0; i < 100'000; ++i) {
    buffer.append(std::string(100, 'b'));
    buffer.consume(100);
  }
  EXPECT_LE(buffer.space(1).size() + buffer.content().size(), 8192U);
}

struct Utf8Row {
  const char* name;
  std::string_view in;
  std::string_view out;
};

void PrintTo(const Utf8Row& row, std::ostream* out) { *out << row.name; }

struct Utf8Test : ::testing::TestWithParam<Utf8Row> {};

TEST_P(Utf8Test, KeepsWellFormedTextAndReplacesEachOtherByte) {
  EXPECT_EQ(to_utf8(GetParam().in), GetParam().out);
  EXPECT_EQ(is_utf8(GetParam().in), GetParam().in == GetParam().out);
}

TEST(Utf8, OneWrongByteIsFoundAnywhereInALongText) {
  const std::string ascii(25, 'a');
  EXPECT_TRUE(is_utf8(ascii));
  for (std::size_t at = 0; at < ascii.size(); ++at)
    for (const char byte : {'\x80', '\xff'}) {
      std::string text = ascii;
      text[at] = byte;
      EXPECT_FALSE(is_utf8(text)) << at;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Rfc3629, Utf8Test,
    ::testing::Values(Utf8Row{"Empty", "", ""}, Utf8Row{"Ascii", "can0\x7f", "can0\x7f"},
                      Utf8Row{"TwoBytes", "\xc2\x80\xdf\xbf", "\xc2\x80\xdf\xbf"},
                      Utf8Row{"ThreeBytes", "\xe0\xa0\x80\xed\x9f\xbf\xef\xbf\xbd",
                              "\xe0\xa0\x80\xed\x9f\xbf\xef\xbf\xbd"},
                      Utf8Row{"FourBytes", "\xf0\x90\x80\x80\xf4\x8f\xbf\xbf",
                              "\xf0\x90\x80\x80\xf4\x8f\xbf\xbf"},
                      Utf8Row{"OverlongTwo", "\xc1\xbf", "\ufffd\ufffd"},
                      Utf8Row{"OverlongThree", "\xe0\x9f\xbf", "\ufffd\ufffd\ufffd"},
                      Utf8Row{"OverlongFour", "\xf0\x8f\xbf\xbf", "\ufffd\ufffd\ufffd\ufffd"},
                      Utf8Row{"Surrogate", "\xed\xa0\x80", "\ufffd\ufffd\ufffd"},
                      Utf8Row{"BeyondUnicode", "\xf4\x90\x80\x80", "\ufffd\ufffd\ufffd\ufffd"},
                      Utf8Row{"LoneTail", "a\x80z", "a\ufffdz"},
                      Utf8Row{"CutShort", "a\xe2\x82", "a\ufffd\ufffd"},
                      Utf8Row{"CutByAscii", "\xe2\x82z", "\ufffd\ufffdz"}),
    [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace mlcca::control
