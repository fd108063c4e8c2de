// SPDX-License-Identifier: BSD-2-Clause
// Parses and prints integers (and binary floating-point numbers) in texts from outside. Exact
// numbers with a decimal point are in decimal.hpp.
#pragma once
#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace mlcca {

inline constexpr int kDecimalBase = 10;
inline constexpr int kHexadecimalBase = 16;

namespace detail {

/// The number at the front of a text and how many characters it takes; size 0 without a number.
template <class Number>
struct AtFront {
  std::optional<Number> number;
  std::size_t size = 0;
};

template <class Number>
AtFront<Number> read_front(std::string_view text, int base) {
  Number number{};
  std::from_chars_result read{};
  if constexpr (std::is_floating_point_v<Number>)
    read = std::from_chars(text.data(), text.data() + text.size(), number);
  else
    read = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (read.ec != std::errc{}) return {};
  return {number, static_cast<std::size_t>(read.ptr - text.data())};
}

}  // namespace detail

/// Removes a number from the front of `text`: digits, behind a minus sign if `Number` is signed.
/// Returns nullopt and leaves `text` unchanged if there is no number or it does not fit `Number`.
template <class Number>
std::optional<Number> take_number(std::string_view& text, int base = kDecimalBase) {
  const auto front = detail::read_front<Number>(text, base);
  text.remove_prefix(front.size);
  return front.number;
}

/// The number that `text` consists of. Nullopt if anything else is in it, or if it does not fit.
template <class Number>
std::optional<Number> number_in(std::string_view text, int base = kDecimalBase) {
  const auto front = detail::read_front<Number>(text, base);
  return front.size == text.size() ? front.number : std::nullopt;
}

/// As number_in(), but hexadecimal behind the prefix 0x.
template <std::unsigned_integral Number>
std::optional<Number> prefixed_number_in(std::string_view text) {
  if (!text.starts_with("0x")) return number_in<Number>(text);
  return number_in<Number>(text.substr(2), kHexadecimalBase);
}

/// The number in hexadecimal with prefix, lower case and without leading zeros: "0x1f".
template <std::unsigned_integral Number>
std::string hexadecimal(Number number) {
  std::array<char, 2 * sizeof(Number)> digits{};
  const auto written =
      std::to_chars(digits.data(), digits.data() + digits.size(), number, kHexadecimalBase);
  return "0x" + std::string(digits.data(), written.ptr);
}

}  // namespace mlcca
