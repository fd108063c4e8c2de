// SPDX-License-Identifier: BSD-2-Clause
// Decimal fractions are read as integers: mantissa * unit / 10^decimals, rounded once.
#include "tools/values.hpp"

#include <fmt/format.h>
#include <linux/can.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/model/text.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::tools {
namespace {

__extension__ using Wide = unsigned __int128;

/// One `name` is numerator / denominator times the `base` unit of an attribute.
struct Unit {
  std::string_view base;
  std::string_view name;
  Value numerator;
  Value denominator = 1;
};

constexpr std::array kUnits = {
    Unit{"ns", "ns", 1},
    Unit{"ns", "us", 1'000},
    Unit{"ns", "\u00b5s", 1'000},  // micro sign
    Unit{"ns", "\u03bcs", 1'000},  // Greek mu
    Unit{"ns", "ms", 1'000'000},
    Unit{"ns", "s", 1'000'000'000},
    Unit{"ns", "min", 60'000'000'000},
    Unit{"ns", "h", 3'600'000'000'000},
    Unit{"bytes/s", "B/s", 1},
    Unit{"bytes/s", "kB/s", 1'000},
    Unit{"bytes/s", "MB/s", 1'000'000},
    Unit{"bytes/s", "GB/s", 1'000'000'000},
    Unit{"bytes/s", "KiB/s", 1U << 10U},
    Unit{"bytes/s", "MiB/s", 1U << 20U},
    Unit{"bytes/s", "bit/s", 1, 8},
    Unit{"bytes/s", "kbit/s", 125},
    Unit{"bytes/s", "Mbit/s", 125'000},
    Unit{"bytes/s", "Gbit/s", 125'000'000},
    Unit{"1e-9", "%", 10'000'000},
    Unit{"1e-9", "ppm", 1'000},
    Unit{"1e-9", "ppb", 1},
    Unit{"events", "", 1},
    Unit{"events", "events", 1},
    Unit{"bytes", "", 1},
    Unit{"bytes", "B", 1},
    Unit{"bytes", "bytes", 1},
    Unit{"bytes", "kB", 1'000},
    Unit{"bytes", "KiB", 1U << 10U},
};

/// Of rates in bit/s.
constexpr std::array kBitRates = {
    Unit{"", "bit/s", 1},
    Unit{"", "kbit/s", 1'000},
    Unit{"", "Mbit/s", 1'000'000},
    Unit{"", "Gbit/s", 1'000'000'000},
    Unit{"", "k", 1'000},
    Unit{"", "M", 1'000'000},
    Unit{"", "G", 1'000'000'000},
    Unit{"", "B/s", 8},
    Unit{"", "kB/s", 8'000},
    Unit{"", "MB/s", 8'000'000},
    Unit{"", "GB/s", 8'000'000'000},
    Unit{"", "KiB/s", 8U << 10U},
    Unit{"", "MiB/s", 8U << 20U},
    Unit{"", "Byte/s", 8},
    Unit{"", "kByte/s", 8'000},
    Unit{"", "KByte/s", 8'000},
    Unit{"", "MByte/s", 8'000'000},
    Unit{"", "GByte/s", 8'000'000'000},
};

/// "ns, us, ms, s, min or h"; spellings that are not ASCII are accepted but not named.
std::string units_of(std::string_view base) {
  std::vector<std::string_view> names;
  for (const auto& unit : kUnits)
    if (unit.base == base && !unit.name.empty() && static_cast<unsigned char>(unit.name[0]) < 0x80)
      names.push_back(unit.name);
  const auto last = names.back();
  names.pop_back();
  return names.empty() ? std::string(last) : fmt::format("{} or {}", fmt::join(names, ", "), last);
}

bool same_letters(std::string_view a, std::string_view b) {
  constexpr auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  };
  return std::ranges::equal(a, b, {}, lower, lower);
}

Result<Attribute> attribute_named(std::string_view name) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    if (name == kAttributeTable[i].name) return attribute_at(i);
    if (same_letters(name, kAttributeTable[i].name))
      return fail(
          fmt::format("unknown attribute '{}': it is spelled {}", name, kAttributeTable[i].name));
    names.emplace_back(kAttributeTable[i].name);
  }
  return fail(
      fmt::format("unknown attribute '{}': must be one of {}", name, fmt::join(names, ", ")));
}

/// digits / 10^decimals
struct Decimal {
  Value digits = 0;
  int decimals = 0;
};

/// Reads "12.5"; nullopt for anything else, and for more than 64 bits of digits.
std::optional<Decimal> read_decimal(std::string_view text) {
  const auto point = std::min(text.find('.'), text.size());
  std::string digits(text.substr(0, point));
  Decimal result;
  if (point < text.size()) {
    auto fraction = text.substr(point + 1);
    if (digits.empty() || fraction.empty()) return std::nullopt;
    while (!fraction.empty() && fraction.back() == '0') fraction.remove_suffix(1);
    digits += fraction;
    result.decimals = static_cast<int>(fraction.size());
  }
  const auto* end = digits.data() + digits.size();
  const auto read = std::from_chars(digits.data(), end, result.digits);
  // 10^18 is the largest power of ten that leaves room for a denominator of 8.
  if (read.ec != std::errc{} || read.ptr != end || result.decimals > 18) return std::nullopt;
  return result;
}

bool rounds_up(Attribute attribute, Role role) {
  const bool more_traffic = role == Role::offered && attribute == Attribute::jitter;
  return more_traffic || info(attribute).better == Better::larger;
}

/// The value in the base unit; nullopt when 64 bits cannot hold it.
std::optional<Value> scaled(const Decimal& number, const Unit& unit, bool up) {
  Wide divisor = unit.denominator;
  for (int i = 0; i < number.decimals; ++i) divisor *= 10;
  const Wide product = static_cast<Wide>(number.digits) * unit.numerator;
  const Wide result = product / divisor + (up && product % divisor != 0 ? 1 : 0);
  if (result >= kUnbounded) return std::nullopt;
  return static_cast<Value>(result);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

Result<Value> read_value(Attribute attribute, std::string_view text, Role role) {
  const auto base = std::string_view(info(attribute).unit);
  const auto split = std::min(text.find_first_not_of("0123456789."), text.size());
  const auto unit_name = trimmed(text.substr(split));
  const auto* const unit = std::ranges::find_if(
      kUnits, [&](const Unit& u) { return u.base == base && u.name == unit_name; });
  const auto number = read_decimal(trimmed(text.substr(0, split)));
  if (!number)
    return fail(split == 0 ? "must be a number of 0 or more, such as 50 or 12.5"
                           : "must be digits, at most one point and 18 decimals, and fit 64 bits "
                             "without the point");
  if (unit == kUnits.end())
    return fail(unit_name.empty() ? "needs a unit: " + units_of(base)
                                  : fmt::format("'{}' is not a unit of it: must be {}", unit_name,
                                                units_of(base)));
  const auto value = scaled(*number, *unit, rounds_up(attribute, role));
  if (!value) return fail("too large");
  if (attribute == Attribute::period && *value == 0) return fail("must be more than 0 ns");
  if (attribute == Attribute::packet_loss && *value > kCertainLoss)
    return fail("must be at most 100%");
  return *value;
}

/// A number and what follows it.
struct Quantity {
  Decimal number;
  std::string_view unit;
};

Result<Quantity> read_quantity(std::string_view text) {
  text = trimmed(text);
  const auto split = std::min(text.find_first_not_of("0123456789."), text.size());
  const auto number = read_decimal(trimmed(text.substr(0, split)));
  if (!number)
    return fail(
        fmt::format("'{}': must begin with a number of 0 or more, such as 50 or 12.5", text));
  return Quantity{*number, trimmed(text.substr(split))};
}

Result<Value> whole_parts(const Quantity& quantity, Value numerator, Value denominator,
                          Rounding rounding, std::string_view text) {
  const auto value =
      scaled(quantity.number, {"", "", numerator, denominator}, rounding == Rounding::up);
  if (!value) return fail(fmt::format("'{}': too large", text));
  return *value;
}

}  // namespace

Result<std::uint64_t> parse_bit_rate(std::string_view text, Rounding rounding) {
  const auto quantity = read_quantity(text);
  if (!quantity) return std::unexpected(quantity.error());
  const auto* const unit = std::ranges::find(kBitRates, quantity->unit, &Unit::name);
  if (unit == kBitRates.end())
    return fail(
        fmt::format("'{}': needs a unit of bit/s, kbit/s, Mbit/s, Gbit/s, B/s, kB/s, MB/s, "
                    "GB/s, KiB/s or MiB/s",
                    text));
  auto rate = whole_parts(*quantity, unit->numerator, 1, rounding, text);
  if (rate && *rate == 0) return fail(fmt::format("'{}': must be 1 bit/s or more", text));
  return rate;
}

Result<std::uint64_t> parse_share(std::string_view text, std::uint64_t whole, Rounding rounding) {
  const auto quantity = read_quantity(text);
  if (!quantity) return std::unexpected(quantity.error());
  if (!quantity->unit.empty() && quantity->unit != "%")
    return fail(fmt::format("'{}': must be a share such as 0.25 or 25%", text));
  auto parts = whole_parts(*quantity, whole, quantity->unit.empty() ? 1 : 100, rounding, text);
  if (parts && *parts > whole) return fail(fmt::format("'{}': must be at most 1 or 100%", text));
  return parts;
}

Result<std::uint64_t> parse_microseconds(std::string_view text, Rounding rounding) {
  const auto quantity = read_quantity(text);
  if (!quantity) return std::unexpected(quantity.error());
  if (!quantity->unit.empty() && quantity->unit != "us")
    return fail(fmt::format("'{}': must be a number of microseconds", text));
  return whole_parts(*quantity, 1'000, 1, rounding, text);
}

std::string print_bit_rate(std::uint64_t bits_per_second) {
  constexpr std::uint64_t mega = 1'000'000;
  return fmt::format("{}.{:06} Mbit/s", bits_per_second / mega, bits_per_second % mega);
}

Result<control::Attribute> parse_attribute(std::string_view text, Role role) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos)
    return fail(fmt::format("'{}': must be Name=Value, such as Period=50ms", text));
  const auto attribute = attribute_named(trimmed(text.substr(0, equals)));
  if (!attribute) return std::unexpected(attribute.error());
  const auto value = read_value(*attribute, trimmed(text.substr(equals + 1)), role);
  if (!value) return fail(fmt::format("{}: {}", text, value.error().text));
  return control::Attribute{.name = info(*attribute).name,
                            .value = *value,
                            .unit = info(*attribute).unit,
                            .dynamic = false};
}

std::optional<UnitScale> unit_scale(std::string_view base, std::string_view name) {
  const auto* const unit =
      std::ranges::find_if(kUnits, [&](const Unit& u) { return u.base == base && u.name == name; });
  if (unit == kUnits.end()) return std::nullopt;
  return UnitScale{unit->numerator, unit->denominator};
}

std::string print_value(std::string_view attribute, std::uint64_t value, std::string_view unit) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (attribute == kAttributeTable[i].name) return core::format_value(attribute_at(i), value);
  if (value == kUnbounded) return "unbounded";
  return unit.empty() ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

std::string print_duration(std::uint64_t ns) {
  return ns == kUnbounded ? "for ever" : core::format_value(Attribute::latency, ns);
}

std::string print_bitrate(std::uint32_t bits_per_second) {
  if (bits_per_second == 0) return "unknown";
  if (bits_per_second % 1'000'000 == 0)
    return fmt::format("{} Mbit/s", bits_per_second / 1'000'000);
  if (bits_per_second % 1'000 == 0) return fmt::format("{} kbit/s", bits_per_second / 1'000);
  return fmt::format("{} bit/s", bits_per_second);
}

std::string print_can_id(std::uint32_t can_id) {
  const auto flags = can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_FLAG);
  auto text = (flags & CAN_EFF_FLAG) != 0 ? fmt::format("{:08x}", can_id & CAN_EFF_MASK)
                                          : fmt::format("{:03x}", can_id & CAN_SFF_MASK);
  if ((flags & CAN_RTR_FLAG) != 0) text += " RTR";
  if ((flags & CAN_ERR_FLAG) != 0) text += " error";
  return text;
}

}  // namespace mlcca::tools
