// SPDX-License-Identifier: BSD-2-Clause
// Whole numbers, as texts from outside have them. Those with a point are in decimal.hpp.
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

/// The number at the front of a text, and how many characters it has.
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

/// Takes a number off the front of `text`: digits, and a minus where `Number` has a sign. Nothing,
/// and `text` stays as it is, where none stands there or it does not fit.
template <class Number>
std::optional<Number> take_number(std::string_view& text, int base = kDecimalBase) {
  const auto front = detail::read_front<Number>(text, base);
  text.remove_prefix(front.size);
  return front.number;
}

/// The number that the whole text is.
template <class Number>
std::optional<Number> number_in(std::string_view text, int base = kDecimalBase) {
  const auto front = detail::read_front<Number>(text, base);
  return front.size == text.size() ? front.number : std::nullopt;
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
