// SPDX-License-Identifier: BSD-2-Clause
// The units that people can type, and their conversion into the units that the code uses inside.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "base/decimal.hpp"

namespace mlcca {

/// What a unit measures, named after the unit inside.
enum class Measure : std::uint8_t {
  nanoseconds,
  bytes_per_second,
  bits_per_second,
  parts_per_billion,
  bytes,
  number,
};

/// A unit: one of it is factor * 10^power of the unit inside of its measure.
struct Unit {
  Measure measure;
  std::string_view name;
  std::uint64_t factor;
  int power = 0;

  /// Converts `many` of this unit into the unit inside, rounded up or down. Nullopt if that is not
  /// below 2^64 - 1; see Decimal::scaled().
  [[nodiscard]] std::optional<std::uint64_t> of(const Decimal& many, bool up) const {
    return many.times(factor).scaled(power, up);
  }
};

namespace units {

inline constexpr std::uint64_t kMinute = 60;
inline constexpr std::uint64_t kHour = 60 * kMinute;
inline constexpr std::uint64_t kDay = 24 * kHour;
inline constexpr std::uint64_t kKibi = 1024;

/// All units. Of several spellings of the same unit, output uses the first one.
inline constexpr auto kAll = std::to_array<Unit>({
    {Measure::nanoseconds, "ns", 1},
    {Measure::nanoseconds, "us", 1, 3},
    {Measure::nanoseconds, "\u00b5s", 1, 3},  // micro sign
    {Measure::nanoseconds, "\u03bcs", 1, 3},  // Greek mu
    {Measure::nanoseconds, "ms", 1, 6},
    {Measure::nanoseconds, "s", 1, 9},
    {Measure::nanoseconds, "min", kMinute, 9},
    {Measure::nanoseconds, "h", kHour, 9},
    {Measure::bytes_per_second, "B/s", 1},
    {Measure::bytes_per_second, "kB/s", 1, 3},
    {Measure::bytes_per_second, "MB/s", 1, 6},
    {Measure::bytes_per_second, "GB/s", 1, 9},
    {Measure::bytes_per_second, "KiB/s", kKibi},
    {Measure::bytes_per_second, "MiB/s", kKibi* kKibi},
    {Measure::bytes_per_second, "bit/s", 125, -3},
    {Measure::bytes_per_second, "kbit/s", 125},
    {Measure::bytes_per_second, "Mbit/s", 125, 3},
    {Measure::bytes_per_second, "Gbit/s", 125, 6},
    {Measure::bits_per_second, "bit/s", 1},
    {Measure::bits_per_second, "kbit/s", 1, 3},
    {Measure::bits_per_second, "Mbit/s", 1, 6},
    {Measure::bits_per_second, "Gbit/s", 1, 9},
    {Measure::bits_per_second, "B/s", 8},
    {Measure::bits_per_second, "kB/s", 8, 3},
    {Measure::bits_per_second, "MB/s", 8, 6},
    {Measure::bits_per_second, "GB/s", 8, 9},
    {Measure::bits_per_second, "KiB/s", 8 * kKibi},
    {Measure::bits_per_second, "MiB/s", 8 * kKibi* kKibi},
    {Measure::parts_per_billion, "%", 1, 7},
    {Measure::parts_per_billion, "ppm", 1, 3},
    {Measure::parts_per_billion, "ppb", 1},
    {Measure::bytes, "", 1},
    {Measure::bytes, "B", 1},
    {Measure::bytes, "bytes", 1},
    {Measure::bytes, "kB", 1, 3},
    {Measure::bytes, "KiB", kKibi},
    {Measure::number, "", 1},
    {Measure::number, "events", 1},
});

/// Shares without a unit: 0.01 is 1 %.
inline constexpr auto kPlainShares = std::to_array<Unit>({{Measure::parts_per_billion, "", 1, 9}});

/// Further spellings for spans of time and leases, which can be long.
inline constexpr auto kLongTimes = std::to_array<Unit>({
    {Measure::nanoseconds, "second", 1, 9},
    {Measure::nanoseconds, "seconds", 1, 9},
    {Measure::nanoseconds, "minute", kMinute, 9},
    {Measure::nanoseconds, "minutes", kMinute, 9},
    {Measure::nanoseconds, "hour", kHour, 9},
    {Measure::nanoseconds, "hours", kHour, 9},
    {Measure::nanoseconds, "d", kDay, 9},
    {Measure::nanoseconds, "day", kDay, 9},
    {Measure::nanoseconds, "days", kDay, 9},
    {Measure::nanoseconds, "w", 7 * kDay, 9},
    {Measure::nanoseconds, "week", 7 * kDay, 9},
    {Measure::nanoseconds, "weeks", 7 * kDay, 9},
});

/// Rates as the tools of radios and the daemon of AWDS print them.
inline constexpr auto kRadioRates = std::to_array<Unit>({
    {Measure::bits_per_second, "k", 1, 3},
    {Measure::bits_per_second, "M", 1, 6},
    {Measure::bits_per_second, "G", 1, 9},
    {Measure::bits_per_second, "Byte/s", 8},
    {Measure::bits_per_second, "kByte/s", 8, 3},
    {Measure::bits_per_second, "KByte/s", 8, 3},
    {Measure::bits_per_second, "MByte/s", 8, 6},
    {Measure::bits_per_second, "GByte/s", 8, 9},
});

/// The measure of an attribute whose unit in the attribute table (AttributeInfo::unit) is `base`.
constexpr Measure measure_of(std::string_view base) {
  if (base == "ns") return Measure::nanoseconds;
  if (base == "bytes/s") return Measure::bytes_per_second;
  if (base == "1e-9") return Measure::parts_per_billion;
  return base == "bytes" ? Measure::bytes : Measure::number;
}

/// The unit of that name and measure; nullptr if there is none.
constexpr const Unit* find(Measure measure, std::string_view name,
                           std::span<const Unit> among = kAll) {
  const auto found = std::ranges::find_if(
      among, [&](const Unit& u) { return u.measure == measure && u.name == name; });
  return found == among.end() ? nullptr : &*found;
}

}  // namespace units
}  // namespace mlcca
