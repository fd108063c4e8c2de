// SPDX-License-Identifier: BSD-2-Clause
// Whole numbers, as texts from outside have them. Those with a point are in decimal.hpp.
#pragma once
#include <array>
#include <charconv>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace mlcca {

inline constexpr int kDecimalBase = 10;
inline constexpr int kHexadecimalBase = 16;

/// Takes a number off the front of `text`: digits, and a minus where `Number` has a sign. Nothing,
/// and `text` stays as it is, where none stands there or it does not fit.
template <class Number>
std::optional<Number> take_number(std::string_view& text, int base = kDecimalBase) {
  Number number{};
  const char* const end = text.data() + text.size();
  std::from_chars_result read{};
  if constexpr (std::is_floating_point_v<Number>)
    read = std::from_chars(text.data(), end, number);
  else
    read = std::from_chars(text.data(), end, number, base);
  if (read.ec != std::errc{}) return std::nullopt;
  text = std::string_view(read.ptr, end);
  return number;
}

/// The number that the whole text is.
template <class Number>
std::optional<Number> number_in(std::string_view text, int base = kDecimalBase) {
  const auto number = take_number<Number>(text, base);
  return text.empty() ? number : std::nullopt;
}

/// The same, in hexadecimal behind 0x.
template <std::unsigned_integral Number>
std::optional<Number> prefixed_number_in(std::string_view text) {
  if (!text.starts_with("0x")) return number_in<Number>(text);
  return number_in<Number>(text.substr(2), kHexadecimalBase);
}

/// "0x1f": lower case, without leading zeros.
template <std::unsigned_integral Number>
std::string hexadecimal(Number number) {
  std::array<char, 2 * sizeof(Number)> digits{};
  const auto written =
      std::to_chars(digits.data(), digits.data() + digits.size(), number, kHexadecimalBase);
  return "0x" + std::string(digits.data(), written.ptr);
}

}  // namespace mlcca
