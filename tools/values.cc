// SPDX-License-Identifier: BSD-2-Clause
#include "tools/values.hpp"

#include <fmt/format.h>
#include <linux/can.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "core/model/text.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::tools {
namespace {

using units::measure_of;

/// The units to name in an error: "ns, us, ms, s, min or h". Accepted spellings that are not ASCII
/// are left out.
std::string units_of(std::string_view base) {
  std::vector<std::string_view> names;
  for (const auto& unit : units::kAll)
    if (unit.measure == measure_of(base) && !unit.name.empty() &&
        static_cast<unsigned char>(unit.name[0]) < 0x80)
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

/// Whether the digits fit 64 bits and there are at most 18 decimals.
bool is_moderate(const Decimal& number) {
  constexpr std::size_t most_decimals = 18;
  return number.decimals() <= most_decimals &&
         (number.digits().empty() || number_in<Value>(number.digits()));
}

bool rounds_up(Attribute attribute, Role role) {
  const bool more_traffic = role == Role::offered && attribute == Attribute::jitter;
  return more_traffic || info(attribute).better == Better::larger;
}

Result<Value> read_value(Attribute attribute, std::string_view text, Role role) {
  const auto base = std::string_view(info(attribute).unit);
  const auto [number, unit_name] = number_and_unit(text);
  const Unit* const unit = units::find(measure_of(base), unit_name);
  if (!number || !is_moderate(*number))
    return fail(unit_name == trimmed(text)
                    ? "must be a number of 0 or more, such as 50 or 12.5"
                    : "must be digits, at most one point and 18 decimals, and fit 64 bits "
                      "without the point");
  if (unit == nullptr)
    return fail(unit_name.empty() ? "needs a unit: " + units_of(base)
                                  : fmt::format("'{}' is not a unit of it: must be {}", unit_name,
                                                units_of(base)));
  const auto value = unit->of(*number, rounds_up(attribute, role));
  if (!value) return fail("too large");
  if (attribute == Attribute::period && *value == 0) return fail("must be more than 0 ns");
  if (attribute == Attribute::packet_loss && *value > kCertainLoss)
    return fail("must be at most 100%");
  return *value;
}

/// Parses a number with a unit. `most`, for the error text, is the largest value.
Result<WithUnit> read_quantity(std::string_view text, std::string_view most) {
  constexpr std::size_t most_decimals = 18;
  auto quantity = number_and_unit(text);
  if (!quantity.number)
    return fail(fmt::format("'{}': must begin with a number of 0 or more, such as 50 or 12.5",
                            trimmed(text)));
  if (quantity.number->decimals() > most_decimals)
    return fail(fmt::format("'{}': must have at most {} decimals", trimmed(text), most_decimals));
  if (!is_moderate(*quantity.number))
    return fail(
        fmt::format("'{}': too large, or too many digits: at most {}", trimmed(text), most));
  return quantity;
}

Result<Value> whole_parts(const Decimal& number, int power, Rounding rounding,
                          std::string_view text, std::string_view most) {
  const auto value = number.scaled(power, rounding == Rounding::up);
  if (!value) return fail(fmt::format("'{}': too large: at most {}", text, most));
  return *value;
}

constexpr std::string_view kMostRate = "18446744073709551615 bit/s";
constexpr std::string_view kMostMicroseconds = "18446744073709551 us";

}  // namespace

Result<std::uint64_t> parse_bit_rate(std::string_view text, Rounding rounding) {
  const auto quantity = read_quantity(text, kMostRate);
  if (!quantity) return std::unexpected(quantity.error());
  const Unit* unit = units::find(Measure::bits_per_second, quantity->unit);
  if (unit == nullptr)
    unit = units::find(Measure::bits_per_second, quantity->unit, units::kRadioRates);
  if (unit == nullptr)
    return fail(
        fmt::format("'{}': needs a unit of k, M or G (bit/s), bit/s, kbit/s, Mbit/s, Gbit/s, B/s, "
                    "kB/s, MB/s, GB/s, KiB/s or MiB/s",
                    text));
  auto rate =
      whole_parts(quantity->number->times(unit->factor), unit->power, rounding, text, kMostRate);
  if (rate && *rate == 0) return fail(fmt::format("'{}': must be 1 bit/s or more", text));
  return rate;
}

Result<std::uint32_t> parse_bus_rate(std::string_view text, std::uint32_t most) {
  const bool plain =
      !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
  const auto rate =
      parse_bit_rate(plain ? std::string(text) + " bit/s" : std::string(text), Rounding::down);
  if (!rate)
    return fail(fmt::format("'{}': must be a bit rate such as 500000, 500k or 0.5 Mbit/s", text));
  if (*rate > most)
    return fail(fmt::format("'{}': a CAN bus has at most {}", text, print_bitrate(most)));
  constexpr std::uint32_t least = 1'000;
  if (*rate < least)
    return fail(fmt::format("'{}': a CAN bus has at least {}; 500 kbit/s are 500000 or 500k", text,
                            print_bitrate(least)));
  return static_cast<std::uint32_t>(*rate);
}

Result<std::uint64_t> parse_share(std::string_view text, std::uint64_t whole, Rounding rounding) {
  constexpr std::string_view most = "1 or 100%";
  const auto quantity = read_quantity(text, most);
  if (!quantity) return std::unexpected(quantity.error());
  if (!quantity->unit.empty() && quantity->unit != "%")
    return fail(fmt::format("'{}': must be a share such as 0.25 or 25%", text));
  const int power = quantity->unit.empty() ? 0 : -2;
  auto parts = whole_parts(quantity->number->times(whole), power, rounding, text, most);
  if (parts && *parts > whole) return fail(fmt::format("'{}': must be at most {}", text, most));
  return parts;
}

Result<std::uint64_t> parse_microseconds(std::string_view text, Rounding rounding) {
  const auto quantity = read_quantity(text, kMostMicroseconds);
  if (!quantity) return std::unexpected(quantity.error());
  if (!quantity->unit.empty() && quantity->unit != "us")
    return fail(fmt::format("'{}': must be a number of microseconds", text));
  return whole_parts(*quantity->number, 3, rounding, text, kMostMicroseconds);
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

Result<control::Attribute> parse_stated(std::string_view text, Role role) {
  const auto equals = text.find('=');
  const std::string_view name = trimmed(text.substr(0, equals));
  const bool of_table = std::ranges::any_of(
      kAttributeTable, [&](const AttributeInfo& row) { return same_letters(name, row.name); });
  if (of_table || equals == std::string_view::npos || name.empty())
    return parse_attribute(text, role);
  const auto [number, unit] = number_and_unit(text.substr(equals + 1));
  if (!number || !is_moderate(*number))
    return fail(fmt::format(
        "{}: must be a number of 0 or more, such as 50 or 12.5, with at most 18 decimals", text));
  std::string unit_inside(unit);
  if (number->decimals() != 0)
    unit_inside = fmt::format("1e-{}{}{}", number->decimals(), unit.empty() ? "" : " ", unit);
  return control::Attribute{.name = std::string(name),
                            .value = number_in<Value>(number->digits()).value_or(0),
                            .unit = std::move(unit_inside),
                            .dynamic = false};
}

const Unit* unit_of(std::string_view base, std::string_view name) {
  return units::find(measure_of(base), name);
}

std::string print_value(std::string_view attribute, std::uint64_t value, std::string_view unit) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (attribute == kAttributeTable[i].name) return core::format_value(attribute_at(i), value);
  return core::format_user_value(core::of_unit(unit), value);
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
