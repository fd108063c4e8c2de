// SPDX-License-Identifier: BSD-2-Clause
// Well-formed sequences by the syntax of RFC 3629, section 4.
#include "control/utf8.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace mlcca::control {
namespace {

using Byte = unsigned char;

/// A set of well-formed sequences: the first byte is in one range, the second in another, and all
/// further bytes are 0x80 to 0xbf.
struct Sequences {
  Byte first_from, first_to;
  Byte second_from, second_to;
  std::size_t length;
};
constexpr std::array<Sequences, 8> kLonger = {{
    {0xc2, 0xdf, 0x80, 0xbf, 2},
    {0xe0, 0xe0, 0xa0, 0xbf, 3},
    {0xe1, 0xec, 0x80, 0xbf, 3},
    {0xed, 0xed, 0x80, 0x9f, 3},
    {0xee, 0xef, 0x80, 0xbf, 3},
    {0xf0, 0xf0, 0x90, 0xbf, 4},
    {0xf1, 0xf3, 0x80, 0xbf, 4},
    {0xf4, 0xf4, 0x80, 0x8f, 4},
}};

bool within(char c, Byte from, Byte to) {
  return static_cast<Byte>(c) >= from && static_cast<Byte>(c) <= to;
}

bool is_ascii(char c) { return within(c, 0, 0x7f); }

/// The number of characters at the front of `text` that are known to be ASCII: eight are compared
/// at a time, since most texts have no other character. Others may follow.
std::size_t ascii_length(std::string_view text) {
  constexpr std::uint64_t high_bits = 0x8080808080808080;
  std::size_t length = 0;
  for (std::uint64_t eight = 0; text.size() - length >= sizeof eight; length += sizeof eight) {
    std::memcpy(&eight, text.data() + length, sizeof eight);
    if ((eight & high_bits) != 0) break;
  }
  return length;
}

/// The length of the well-formed sequence at the front of `text`, which must not be empty; 0 if
/// there is none.
std::size_t sequence_length(std::string_view text) {
  if (is_ascii(text.front())) return 1;
  for (const auto& row : kLonger) {
    if (!within(text.front(), row.first_from, row.first_to)) continue;
    const bool well_formed = text.size() >= row.length &&
                             within(text[1], row.second_from, row.second_to) &&
                             std::ranges::all_of(text.substr(2, row.length - 2),
                                                 [](char c) { return within(c, 0x80, 0xbf); });
    return well_formed ? row.length : 0;
  }
  return 0;
}

}  // namespace

bool is_utf8(std::string_view text) {
  text.remove_prefix(ascii_length(text));
  while (!text.empty()) {
    const std::size_t n = sequence_length(text);
    if (n == 0) return false;
    text.remove_prefix(n);
  }
  return true;
}

std::string to_utf8(std::string_view text) {
  std::string result;
  result.reserve(text.size() + 2);
  while (!text.empty()) {
    const std::size_t n = sequence_length(text);
    result.append(n == 0 ? std::string_view("\xef\xbf\xbd") : text.substr(0, n));
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return result;
}

}  // namespace mlcca::control
