// SPDX-License-Identifier: BSD-2-Clause
// mktime() converts local time; if it had to correct a field the input was not a date.
#include "tools/times.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <ctime>
#include <optional>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "base/units.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::tools {
namespace {

constexpr std::uint64_t kMillisecond = 1'000'000;
constexpr std::uint64_t kSecond = 1'000'000'000;
constexpr std::uint64_t kDay = units::kDay * kSecond;

/// The unit of a span; units below a millisecond are not accepted.
const Unit* unit_named(std::string_view name) {
  if (name == "m") name = "min";  // as sleep(1) and systemd.time(7) abbreviate it
  if (const Unit* const longer = units::find(Measure::nanoseconds, name, units::kLongTimes))
    return longer;
  const Unit* const unit = units::find(Measure::nanoseconds, name);
  return unit != nullptr && unit->power >= 6 ? unit : nullptr;
}

void skip_blanks(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
}

/// Removes an integer and its unit from the front of `text` and returns nanoseconds; nullopt if
/// there is none.
std::optional<std::uint64_t> take_part(std::string_view& text) {
  const auto digits = text.substr(0, text.find_first_not_of("0123456789"));
  const auto number = Decimal::read(digits);
  if (!number || !number_in<std::uint64_t>(digits)) return std::nullopt;
  text.remove_prefix(digits.size());
  skip_blanks(text);
  const auto length = std::min(text.find_first_of(" 0123456789"), text.size());
  const Unit* const unit = unit_named(text.substr(0, length));
  if (unit == nullptr) return std::nullopt;
  text.remove_prefix(length);
  skip_blanks(text);
  return unit->of(*number, false).value_or(kUnbounded);
}

std::optional<std::uint64_t> read_span(std::string_view text) {
  skip_blanks(text);
  if (text.empty()) return std::nullopt;
  std::uint64_t sum = 0;
  while (!text.empty()) {
    const auto part = take_part(text);
    if (!part) return std::nullopt;
    sum = add_saturating(sum, *part);
  }
  return sum;
}

std::tm local(std::time_t unix_s) {
  std::tm result{};
  ::localtime_r(&unix_s, &result);
  return result;
}

/// Nanoseconds since 1970 of a local time. Nullopt if it does not exist (31 February, 25 o'clock)
/// or is not between 1970 and 2554.
std::optional<std::uint64_t> unix_ns(std::tm when) {
  const auto said = when;
  when.tm_isdst = -1;
  const std::time_t seconds = std::mktime(&when);
  const bool as_said = when.tm_mday == said.tm_mday && when.tm_mon == said.tm_mon &&
                       when.tm_year == said.tm_year && when.tm_hour == said.tm_hour &&
                       when.tm_min == said.tm_min && when.tm_sec == said.tm_sec;
  if (!as_said || seconds < 0) return std::nullopt;
  const auto ns = mul_saturating(static_cast<std::uint64_t>(seconds), kSecond);
  return ns == kUnbounded ? std::nullopt : std::optional(ns);
}

/// Removes `separator` and the number behind it from the front of `text`.
bool take_behind(char separator, std::string_view& text, int& to) {
  if (!text.starts_with(separator)) return false;
  text.remove_prefix(1);
  const auto number = take_number<std::uint16_t>(text);
  to = number.value_or(0);
  return number.has_value();
}

/// Parses "14:00" or "14:00:30".
bool read_time(std::string_view text, std::tm& to) {
  const auto hour = take_number<std::uint16_t>(text);
  if (!hour) return false;
  to.tm_hour = *hour;
  if (!take_behind(':', text, to.tm_min)) return false;
  return text.empty() || (take_behind(':', text, to.tm_sec) && text.empty());
}

/// Parses "2026-11-21", with or without a time of day.
bool read_date(std::string_view text, std::tm& to) {
  const auto year = take_number<std::uint16_t>(text);
  if (!year || *year < 1970 || !take_behind('-', text, to.tm_mon) ||
      !take_behind('-', text, to.tm_mday))
    return false;
  to.tm_year = *year - 1900;
  --to.tm_mon;
  if (text.empty()) return true;
  if (text.front() != ' ') return false;
  skip_blanks(text);
  return read_time(text, to);
}

std::optional<std::uint64_t> read_moment(std::string_view text, std::uint64_t now) {
  auto midnight = local(static_cast<std::time_t>(now / kSecond));
  midnight.tm_hour = midnight.tm_min = midnight.tm_sec = 0;
  const auto ago = [&](std::string_view span) -> std::optional<std::uint64_t> {
    const auto length = read_span(span);
    return length && *length <= now ? std::optional(now - *length) : std::nullopt;
  };
  if (text == "now") return now;
  if (text == "today") return unix_ns(midnight);
  if (text == "yesterday") {
    // Go back 24 hours from noon, because the day before may have 23 or 25 hours.
    midnight.tm_hour = 12;
    const auto noon = unix_ns(midnight);
    if (!noon || *noon < kDay) return std::nullopt;
    auto before = local(static_cast<std::time_t>((*noon - kDay) / kSecond));
    before.tm_hour = before.tm_min = before.tm_sec = 0;
    return unix_ns(before);
  }
  if (text.starts_with('@')) {
    text.remove_prefix(1);
    const auto seconds = take_number<std::uint64_t>(text);
    if (!seconds || !text.empty() || *seconds > kUnbounded / kSecond) return std::nullopt;
    return *seconds * kSecond;
  }
  if (text.starts_with('-')) return ago(text.substr(1));
  if (text.ends_with(" ago")) return ago(text.substr(0, text.size() - 4));
  auto today = midnight;
  if (read_time(text, today)) return unix_ns(today);
  std::tm when{};
  return read_date(text, when) ? unix_ns(when) : std::nullopt;
}

}  // namespace

Result<std::uint64_t> parse_span(std::string_view text) {
  const auto span = read_span(text);
  if (!span)
    return fail(
        fmt::format("'{}': must be whole numbers with units of ms, s, min, h, d or w, such "
                    "as 30s",
                    text));
  if (*span == kUnbounded) return fail(fmt::format("'{}': too long", text));
  return *span;
}

Result<std::uint64_t> parse_moment(std::string_view text, std::uint64_t now_unix_ns) {
  const auto moment = read_moment(text, now_unix_ns);
  if (!moment)
    return fail(
        fmt::format("'{}': must be a moment since 1970, such as '2026-11-21 14:00:00', "
                    "14:00, today, yesterday, -1h, '10 min ago' or @1700000000",
                    text));
  return *moment;
}

std::string print_moment(std::uint64_t unix_ns) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S}.{:03}",
                     local(static_cast<std::time_t>(unix_ns / kSecond)),
                     unix_ns % kSecond / kMillisecond);
}

std::string print_second(std::uint64_t unix_s) {
  if (unix_s == 0) return "never";
  const auto seconds = static_cast<std::time_t>(unix_s);
  std::tm local{};
  ::localtime_r(&seconds, &local);
  return fmt::format("{:%Y-%m-%d %H:%M:%S}", local);
}

}  // namespace mlcca::tools
