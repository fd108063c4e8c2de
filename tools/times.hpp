// SPDX-License-Identifier: BSD-2-Clause
// Moments and spans of time for people: a small part of the forms of journalctl.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace mlcca::tools {

/// Nanoseconds of a span: "30s", "1h 30min". Integers, each with a unit (ms, s, m, min, h, d, w, or
/// second, minute, hour, day, week and their plurals), are added up. A day has 24 hours.
Result<std::uint64_t> parse_span(std::string_view text);

/// Nanoseconds since 1970 of a moment: "2026-11-21 14:00:00" (without the seconds or the time of
/// day, too), "14:00" of today, "now", "today", "yesterday", "-1h", "10 min ago", "@1700000000".
/// Dates and times are local ones (TZ).
Result<std::uint64_t> parse_moment(std::string_view text, std::uint64_t now_unix_ns);

/// Nanoseconds since 1970 as local time: "2023-11-14 22:13:20.123".
std::string print_moment(std::uint64_t unix_ns);
/// Seconds since 1970 as local time: "2023-11-14 22:13:20"; 0 is "never".
std::string print_second(std::uint64_t unix_s);

}  // namespace mlcca::tools
