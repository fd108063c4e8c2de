// SPDX-License-Identifier: BSD-2-Clause
// Moments and spans of time as people write and read them, a small part of what journalctl takes.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.hpp"

namespace mlcca::tools {

/// Nanoseconds of "30s" or "1h 30min": whole numbers, each with a unit (ms, s, m, min, h, d, w, or
/// second, minute, hour, day, week and their plurals), added up. A day has 24 hours.
Result<std::uint64_t> parse_span(std::string_view text);

/// Nanoseconds since 1970 of "2026-11-21 14:00:00" (the seconds, or the whole time, may be left
/// out), "14:00" of today, "now", "today", "yesterday", "-1h", "10 min ago" or "@1700000000".
/// Dates and times are local ones; TZ says where.
Result<std::uint64_t> parse_moment(std::string_view text, std::uint64_t now_unix_ns);

/// "2023-11-14 22:13:20.123", local time, of nanoseconds since 1970.
std::string print_moment(std::uint64_t unix_ns);
/// "2023-11-14 22:13:20", local time, of seconds since 1970; "never" of 0.
std::string print_second(std::uint64_t unix_s);

}  // namespace mlcca::tools
