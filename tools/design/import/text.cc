// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/text.hpp"

#include <array>

#include "control/utf8.hpp"

namespace mlcca::tools::design {
namespace {

/// The code points of 0x80 to 0x9f in Windows-1252; 0: not assigned.
constexpr std::array<char16_t, 32> kWindows = {
    0x20ac, 0,      0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160,
    0x2039, 0x0152, 0,      0x017d, 0,      0,      0x2018, 0x2019, 0x201c, 0x201d, 0x2022,
    0x2013, 0x2014, 0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0,      0x017e, 0x0178};
constexpr char16_t kReplacement = 0xfffd;

/// Appends a code point from 0x80 to 0xffff in UTF-8.
void append(std::string& to, char16_t point) {
  constexpr unsigned two = 0x800;
  if (point < two) {
    to += static_cast<char>(0xc0U | (point >> 6U));
  } else {
    to += static_cast<char>(0xe0U | (point >> 12U));
    to += static_cast<char>(0x80U | ((point >> 6U) & 0x3fU));
  }
  to += static_cast<char>(0x80U | (point & 0x3fU));
}

}  // namespace

std::string utf8_of(std::string_view text, bool& converted) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  converted = !control::is_utf8(text);
  if (!converted) return std::string(text);
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80U) {
      out += c;
      continue;
    }
    const auto point = byte < 0xa0U ? kWindows.at(byte - 0x80U) : static_cast<char16_t>(byte);
    append(out, point == 0 ? kReplacement : point);
  }
  return out;
}

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && static_cast<unsigned char>(text.front()) <= ' ') text.remove_prefix(1);
  while (!text.empty() && static_cast<unsigned char>(text.back()) <= ' ') text.remove_suffix(1);
  return text;
}

std::string stem_of_file(std::string_view path) {
  const auto name = path.substr(path.rfind('/') + 1);
  const auto dot = name.rfind('.');
  return std::string(dot == std::string_view::npos || dot == 0 ? name : name.substr(0, dot));
}

}  // namespace mlcca::tools::design
