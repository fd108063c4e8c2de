// SPDX-License-Identifier: BSD-2-Clause
// Exact decimal numbers of any length. A value is multiplied and its decimal point is moved on the
// digits; it is rounded once, when it becomes an integer. So a value that a person typed is rounded
// to the safe side and never twice.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>

#include "base/number.hpp"

namespace mlcca {

/// A decimal number of 0 or more. The text that it is read from may be of any length; the caller
/// limits that.
class Decimal {
 public:
  /// Reads digits with at most one point between them ("12", "0.5"). Nullopt for any other text,
  /// also for a sign, an exponent, ".5" and "5.".
  static std::optional<Decimal> read(std::string_view text) {
    const auto point = std::min(text.find('.'), text.size());
    Decimal out;
    out.digits_ = text.substr(0, point);
    if (out.digits_.empty()) return std::nullopt;
    if (point < text.size()) {
      const auto fraction = text.substr(point + 1);
      if (fraction.empty()) return std::nullopt;
      out.digits_ += fraction;
      out.decimals_ = fraction.size();
    }
    if (out.digits_.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    out.shorten();
    return out;
  }

  /// All significant digits without the point: no leading zeros, and no trailing zeros behind the
  /// point. Empty for 0.
  [[nodiscard]] const std::string& digits() const { return digits_; }
  /// The number of digits behind the point; it can exceed digits().size(), as for 0.05.
  [[nodiscard]] std::size_t decimals() const { return decimals_; }

  /// The exact product.
  [[nodiscard]] Decimal times(std::uint64_t factor) const {
    __extension__ using Wide = unsigned __int128;
    Decimal out;
    out.decimals_ = decimals_;
    Wide carry = 0;
    for (const char digit : std::views::reverse(digits_)) {
      carry += static_cast<Wide>(digit - '0') * factor;
      out.digits_ += static_cast<char>('0' + static_cast<int>(carry % 10));
      carry /= 10;
    }
    for (; carry != 0; carry /= 10)
      out.digits_ += static_cast<char>('0' + static_cast<int>(carry % 10));
    std::ranges::reverse(out.digits_);
    out.shorten();
    return out;
  }

  /// The exact product with 10^power.
  [[nodiscard]] Decimal times_power(int power) const {
    Decimal out = *this;
    if (digits_.empty()) return out;
    const auto decimals = static_cast<std::ptrdiff_t>(decimals_) - power;
    if (decimals < 0) out.digits_.append(static_cast<std::size_t>(-decimals), '0');
    out.decimals_ = static_cast<std::size_t>(std::max<std::ptrdiff_t>(decimals, 0));
    out.shorten();
    return out;
  }

  /// The product with 10^power as an integer, rounded once: up if `up`, down otherwise. Nullopt if
  /// the result would not be below 2^64 - 1, which stands for "no bound".
  [[nodiscard]] std::optional<std::uint64_t> scaled(int power, bool up) const {
    constexpr auto most = std::numeric_limits<std::uint64_t>::max() - 1;
    if (digits_.empty()) return 0;
    const auto whole = static_cast<std::ptrdiff_t>(digits_.size() - decimals_) + power;
    constexpr std::ptrdiff_t longest = std::numeric_limits<std::uint64_t>::digits10 + 1;
    if (whole > longest) return std::nullopt;
    auto digits = digits_.substr(0, static_cast<std::size_t>(std::max<std::ptrdiff_t>(whole, 0)));
    digits.resize(static_cast<std::size_t>(std::max<std::ptrdiff_t>(whole, 1)), '0');
    if (whole <= 0) digits = "0";
    const auto value = number_in<std::uint64_t>(digits);
    const bool exact = whole >= 0 && digits_.find_first_not_of(
                                         '0', static_cast<std::size_t>(whole)) == std::string::npos;
    if (!value || *value > most) return std::nullopt;
    if (exact || !up) return value;
    return *value == most ? std::nullopt : std::optional(*value + 1);
  }

  /// The number in its shortest form: "12.5".
  [[nodiscard]] std::string text() const {
    std::string out = digits_;
    if (out.size() <= decimals_) out.insert(0, decimals_ + 1 - out.size(), '0');
    if (decimals_ > 0) out.insert(out.size() - decimals_, 1, '.');
    return out;
  }

 private:
  void shorten() {
    for (; decimals_ > 0 && digits_.ends_with('0'); --decimals_) digits_.pop_back();
    digits_.erase(0, std::min(digits_.find_first_not_of('0'), digits_.size()));
    if (digits_.empty()) decimals_ = 0;
  }

  std::string digits_;  ///< empty for 0
  std::size_t decimals_ = 0;
};

/// The parts of a text such as "12.5 ms", without the blanks around them. `number` is nullopt if
/// the text does not begin with a decimal number. `unit` is a view into the text that was read.
struct WithUnit {
  std::optional<Decimal> number;
  std::string_view unit;
};

inline std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

/// Separates a number from the unit behind it.
inline WithUnit number_and_unit(std::string_view text) {
  text = trimmed(text);
  const auto split = std::min(text.find_first_not_of("0123456789."), text.size());
  return {Decimal::read(text.substr(0, split)), trimmed(text.substr(split))};
}

}  // namespace mlcca
