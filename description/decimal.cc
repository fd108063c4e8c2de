// SPDX-License-Identifier: BSD-2-Clause
#include "description/decimal.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <system_error>

namespace mlcca::description {
namespace {

/// Nothing if it does not fit below kUnbounded.
std::optional<Value> whole(std::string_view digits) {
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  if (digits.empty()) return Value{0};
  Value value = 0;
  const auto [stop, error] = std::from_chars(digits.begin(), digits.end(), value);
  if (error != std::errc{} || stop != digits.end() || value == kUnbounded) return std::nullopt;
  return value;
}

}  // namespace

std::optional<Value> scaled(std::string_view decimal, int shift, Rounding rounding) {
  const auto point = std::min(decimal.find('.'), decimal.size());
  std::string digits(decimal.substr(0, point));
  if (point < decimal.size()) digits += decimal.substr(point + 1);
  const auto cut = static_cast<int>(point) + shift;
  const auto kept = static_cast<std::size_t>(std::max(cut, 0));
  if (kept > digits.size()) digits.append(kept - digits.size(), '0');
  const auto value = whole(std::string_view(digits).substr(0, kept));
  const bool exact = digits.find_first_not_of('0', kept) == std::string::npos;
  if (!value || exact || rounding == Rounding::down) return value;
  return *value + 1 == kUnbounded ? std::nullopt : std::optional(*value + 1);
}

}  // namespace mlcca::description
