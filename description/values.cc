// SPDX-License-Identifier: BSD-2-Clause
// Checks a value against its simple type.
#include "description/values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>

#include "base/ascii.hpp"
#include "base/number.hpp"
#include "description/problems.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {

namespace {

constexpr std::size_t kShownValue = 80;  // bytes of a value that are quoted

/// Greedy matching suffices: make-grammar refuses patterns in which a run needs a character that an
/// earlier one could take.
bool fits(Form form, std::string_view text) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (const auto& run : form) {
    const char* const start = at;
    const char* const stop = at + std::min<std::ptrdiff_t>(run.most, end - at);
    at = std::find_if_not(start, stop, [&](char c) { return run.of->has(c); });
    if (at - start < run.least) return false;
  }
  return at == end;
}

/// Parses an optional sign and digits; nullopt for other texts. A value outside the range of long
/// becomes its limit.
std::optional<long> to_integer(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || !std::ranges::all_of(text, is_digit)) return std::nullopt;
  const long value = number_in<long>(text).value_or(std::numeric_limits<long>::max());
  return negative ? -value : value;
}

std::size_t characters(std::string_view utf8) {
  return static_cast<std::size_t>(std::ranges::count_if(
      utf8, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

std::string explain_enumeration(const ValueType& type, std::string_view shown) {
  const auto close = closest(shown, type.values);
  return fmt::format("'{}' is not one of {}{}", shown, fmt::join(type.values, ", "),
                     close.empty() ? "" : fmt::format("; did you mean {}?", close));
}

}  // namespace

bool is_valid(const ValueType& type, std::string_view value) {
  if (!type.forms.empty())
    return std::ranges::any_of(type.forms, [&](Form form) { return fits(form, value); });
  if (!type.values.empty()) return std::ranges::find(type.values, value) != type.values.end();
  if (type.integer) {
    const auto number = to_integer(value);
    return number && *number >= type.least && *number <= type.most;
  }
  const auto length = characters(value);
  return length >= type.shortest && length <= type.longest;
}

std::string explain(const ValueType& type, std::string_view value) {
  const auto shown = clipped(value, kShownValue);
  if (!type.values.empty()) return explain_enumeration(type, shown);
  if (type.integer) {
    if (const auto number = to_integer(value)) {
      if (*number > type.most) return fmt::format("{} is too large: at most {}", shown, type.most);
      return fmt::format("{} is too small: at least {}", shown, type.least);
    }
  } else if (type.forms.empty()) {
    if (characters(value) < type.shortest)
      return fmt::format("is shorter than {} character", type.shortest);
    return fmt::format("is longer than {} characters", type.longest);
  }
  return fmt::format("'{}' is not right: it must be {}", shown, type.words);
}

}  // namespace mlcca::description
