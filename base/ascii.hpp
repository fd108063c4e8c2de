// SPDX-License-Identifier: BSD-2-Clause
// Classes of ASCII characters, independent of the locale (the functions of <cctype> are not).
#pragma once

namespace mlcca {

[[nodiscard]] constexpr bool is_small_letter(char c) { return c >= 'a' && c <= 'z'; }
[[nodiscard]] constexpr bool is_large_letter(char c) { return c >= 'A' && c <= 'Z'; }
[[nodiscard]] constexpr bool is_letter(char c) { return is_small_letter(c) || is_large_letter(c); }
[[nodiscard]] constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
[[nodiscard]] constexpr bool is_alphanumeric(char c) { return is_letter(c) || is_digit(c); }
/// Whether the name of a channel, network, node or gateway may contain `c`.
[[nodiscard]] constexpr bool is_of_name(char c) {
  return is_alphanumeric(c) || c == '.' || c == '_' || c == '-';
}
/// Whether the name of a network interface may contain `c`.
[[nodiscard]] constexpr bool is_of_interface_name(char c) {
  return is_of_name(c) || c == '@' || c == '+';
}

}  // namespace mlcca
