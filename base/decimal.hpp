// SPDX-License-Identifier: BSD-2-Clause
// Decimal numbers of any length, exactly: a value is multiplied and its point moved as digits, and
// rounded once, where it becomes an integer.
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

class Decimal {
 public:
  /// Digits, with at most one point between them; nothing for any other text.
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

  /// All of them, without the point; neither zeros in front nor, behind the point, at the end.
  [[nodiscard]] const std::string& digits() const { return digits_; }
  /// How many are behind the point.
  [[nodiscard]] std::size_t decimals() const { return decimals_; }

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

  /// Times 10^power, exactly.
  [[nodiscard]] Decimal times_power(int power) const {
    Decimal out = *this;
    if (digits_.empty()) return out;
    const auto decimals = static_cast<std::ptrdiff_t>(decimals_) - power;
    if (decimals < 0) out.digits_.append(static_cast<std::size_t>(-decimals), '0');
    out.decimals_ = static_cast<std::size_t>(std::max<std::ptrdiff_t>(decimals, 0));
    out.shorten();
    return out;
  }

  /// Times 10^power as an integer, rounded once. Nothing where it is not below 2^64 - 1, which
  /// stands for "no bound".
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

  /// "12.5", as short as can be.
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

  std::string digits_;  ///< of 0 none
  std::size_t decimals_ = 0;
};

/// The number at the front of "12.5 ms" and what follows it, without the blanks around both.
/// Nothing for the number where there is none.
struct WithUnit {
  std::optional<Decimal> number;
  std::string_view unit;
};

inline std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

inline WithUnit number_and_unit(std::string_view text) {
  text = trimmed(text);
  const auto split = std::min(text.find_first_not_of("0123456789."), text.size());
  return {Decimal::read(text.substr(0, split)), trimmed(text.substr(split))};
}

}  // namespace mlcca
