// SPDX-License-Identifier: BSD-2-Clause
// Prepares texts from outside for output.
#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace mlcca {

/// The beginning of a UTF-8 text, at most `most` bytes, which does not end within a character.
[[nodiscard]] constexpr std::string_view cut(std::string_view text, std::size_t most) {
  constexpr unsigned kind = 0xc0;
  constexpr unsigned continues = 0x80;  // marks the second and further bytes of a character (up to
                                        // 3)
  if (text.size() <= most) return text;
  std::size_t end = most;
  for (int step = 0; step < 3 && end > 0; ++step, --end)
    if ((static_cast<unsigned char>(text[end]) & kind) != continues) return text.substr(0, end);
  const bool is_text = (static_cast<unsigned char>(text[end]) & kind) != continues;
  return text.substr(0, is_text ? end : most);
}

/// The same with '?' in place of control characters, for a line of a log.
[[nodiscard]] inline std::string printable(std::string_view text, std::size_t most) {
  constexpr unsigned char del = 127;
  std::string out(cut(text, most));
  std::ranges::replace_if(out, [](unsigned char c) { return c < ' ' || c == del; }, '?');
  return out;
}

}  // namespace mlcca
