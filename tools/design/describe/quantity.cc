// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/decimal.hpp"
#include "base/number.hpp"
#include "core/model/text.hpp"
#include "description/values.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using description::Dimension;
using description::Unit;

constexpr std::size_t kSeconds = 0;
constexpr std::size_t kBytes = 1;

struct Symbol {
  std::string_view name;
  std::size_t base;  ///< index into Unit
  int magnitude;     ///< power of ten relative to the base unit
};
constexpr auto kSymbols = std::to_array<Symbol>({{"s", kSeconds, 0},
                                                 {"B", kBytes, 0},
                                                 {"m", 2, 0},
                                                 {"kg", 3, 0},
                                                 {"g", 3, -3},
                                                 {"A", 4, 0},
                                                 {"K", 5, 0},
                                                 {"mol", 6, 0},
                                                 {"cd", 7, 0}});

struct Prefix {
  std::string_view name;
  int magnitude;
};
constexpr auto kPrefixes =
    std::to_array<Prefix>({{"n", -9}, {"u", -6}, {"m", -3}, {"k", 3}, {"M", 6}, {"G", 9}});

/// Searches this file's table: a constant in a header has another address in each file.
std::optional<Attribute> built_in_named(std::string_view name) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (name == kAttributeTable[i].name) return attribute_at(i);
  return std::nullopt;
}

/// The value as digits without leading and trailing zeros, and a power of ten.
std::pair<std::string, int> normal(const Quantity& q) {
  const auto number = Decimal::read(q.value);
  if (!number) return {q.value, 0};
  std::string digits = number->digits();
  int magnitude = q.dimension.magnitude - static_cast<int>(number->decimals());
  for (; digits.ends_with('0'); digits.pop_back()) ++magnitude;
  return {digits, digits.empty() ? 0 : magnitude};
}

std::optional<Symbol> symbol_of(std::string_view text) {
  if (const auto* found = std::ranges::find(kSymbols, text, &Symbol::name); found != kSymbols.end())
    return *found;
  for (const auto& prefix : kPrefixes) {
    if (!text.starts_with(prefix.name)) continue;
    const auto* found = std::ranges::find(kSymbols, text.substr(prefix.name.size()), &Symbol::name);
    if (found == kSymbols.end() || found->name == "kg") continue;
    return Symbol{text, found->base, found->magnitude + prefix.magnitude};
  }
  return std::nullopt;
}

/// Multiplies a dimension by a factor such as "mm^2"; `sign` is -1 behind a '/'.
Result<void> multiply(Dimension& by, std::string_view factor, int sign) {
  const auto hat = std::min(factor.find('^'), factor.size());
  const auto symbol = symbol_of(factor.substr(0, hat));
  if (!symbol)
    return fail(
        fmt::format("'{}' is not a unit: must be a product of s, B, m, kg, A, K, mol and "
                    "cd, such as m/s^2",
                    factor));
  int exponent = 1;
  if (hat < factor.size()) {
    const auto read = number_in<int>(factor.substr(hat + 1));
    if (!read || *read < -9 || *read > 9)
      return fail(fmt::format("'{}': the exponent must be a whole number of -9 to 9", factor));
    exponent = *read;
  }
  const int sum = by.unit.at(symbol->base) + sign * exponent;
  if (sum < -9 || sum > 9)
    return fail(fmt::format("'{}': the exponents of a unit sum up to -9 to 9", factor));
  by.unit.at(symbol->base) = static_cast<std::int8_t>(sum);
  by.magnitude += symbol->magnitude * sign * exponent;
  return {};
}

Result<Dimension> parse_unit(std::string_view text) {
  Dimension result;
  int sign = 1;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of(" */"), text.size());
    if (end > 0)
      if (auto done = multiply(result, text.substr(0, end), sign); !done)
        return std::unexpected(done.error());
    if (end < text.size() && text[end] == '/') sign = -1;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return result;
}

/// The name and value of "Name=Value".
Result<std::pair<std::string_view, std::string_view>> split(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos)
    return fail(fmt::format("'{}': must be Name=Value, such as Period=50ms", text));
  return std::pair(trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1)));
}

std::string_view prefix_of(int magnitude) {
  const auto* found = std::ranges::find(kPrefixes, magnitude, &Prefix::magnitude);
  return found == kPrefixes.end() ? std::string_view{} : found->name;
}

bool has_prefix(int magnitude) { return magnitude == 0 || !prefix_of(magnitude).empty(); }

std::string built_in_words(const Quantity& q, Attribute attribute) {
  const std::string_view unit = info(attribute).unit;
  const int magnitude = q.dimension.magnitude;
  const auto with = [&](std::string_view suffix) { return fmt::format("{} {}", q.value, suffix); };
  if (unit == "ns" && has_prefix(magnitude) && magnitude <= 0)
    return with(fmt::format("{}s", prefix_of(magnitude)));
  if (unit == "bytes/s" && has_prefix(magnitude) && magnitude >= 0)
    return with(fmt::format("{}B/s", prefix_of(magnitude)));
  if (unit == "1e-9" && magnitude == -2) return with("%");
  if (unit == "1e-9" && magnitude == -6) return with("ppm");
  if (unit == "1e-9" && magnitude == -9) return with("ppb");
  if (unit == "events" && magnitude == 0) return q.value;
  if (unit == "bytes" && magnitude == 0) return with("bytes");
  const auto value =
      description::to_value(attribute, q.value, q.dimension, description::Side::requirement);
  return value ? core::format_value(attribute, *value)
               : fmt::format("{} x 10^{}", q.value, magnitude);
}

std::string unit_words(const Unit& unit) {
  std::string out;
  for (const auto& symbol : kSymbols) {
    const auto exponent = unit.at(symbol.base);
    if (symbol.magnitude != 0 || exponent == 0) continue;
    out += out.empty() ? "" : " ";
    out += exponent == 1 ? std::string(symbol.name) : fmt::format("{}^{}", symbol.name, exponent);
  }
  return out;
}

/// Whether the first factor of a unit can take a prefix for the complete magnitude.
bool takes_prefix(const Unit& unit) {
  for (std::size_t i = 0; i < unit.size(); ++i)
    if (unit.at(i) != 0) return unit.at(i) == 1 && i != 3;  // kilograms have a prefix already
  return false;
}

}  // namespace

bool names_built_in(std::string_view text) {
  const auto name = trimmed(text.substr(0, text.find('=')));
  constexpr auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  };
  return std::ranges::any_of(kAttributeTable, [&](const AttributeInfo& row) {
    return std::ranges::equal(name, std::string_view(row.name), {}, lower, lower);
  });
}

Result<Quantity> parse_built_in(std::string_view text) {
  // This parser makes the error message.
  const auto known = parse_attribute(text, Role::required);
  if (!known) return std::unexpected(known.error());
  const auto parts = split(text);
  if (!parts) return std::unexpected(parts.error());
  const auto [number, unit_name] = number_and_unit(parts->second);
  const mlcca::Unit* const typed = unit_of(known->unit, unit_name);
  if (!number || typed == nullptr) return fail(fmt::format("'{}': no such unit", text));
  Quantity result{.name = known->name,
                  .value = {},
                  .dimension = description::inside(*built_in_named(known->name))};
  // The magnitude is the power of ten relative to the unit inside; other factors (60, 1024, 125)
  // become part of the value.
  result.dimension.magnitude += typed->power;
  result.value = number->times(typed->factor).text();
  return result;
}

Result<Quantity> parse_user_defined(std::string_view text) {
  const auto parts = split(text);
  if (!parts) return std::unexpected(parts.error());
  const auto [name, value] = *parts;
  if (names_built_in(name))
    return fail(fmt::format("'{}': {} is built in, not user-defined", text, name));
  const auto digits = std::min(value.find_first_not_of("0123456789."), value.size());
  const auto dimension = parse_unit(trimmed(value.substr(digits)));
  if (!dimension) return fail(fmt::format("{}: {}", text, dimension.error().text));
  const auto number = Decimal::read(value.substr(0, digits));
  Quantity result{.name = std::string(name),
                  .value = number ? number->text() : std::string(value.substr(0, digits)),
                  .dimension = *dimension};
  if (auto problem = problem_of(result); !problem.empty())
    return fail(fmt::format("{}: {}", text, problem));
  return result;
}

std::string problem_of(const Quantity& quantity) {
  namespace type = description::type;
  if (!description::is_valid(type::kAttributeName, quantity.name))
    return description::explain(type::kAttributeName, quantity.name);
  if (!description::is_valid(type::kDecimal, quantity.value))
    return description::explain(type::kDecimal, quantity.value);
  if (quantity.dimension.magnitude < -30 || quantity.dimension.magnitude > 30)
    return "the power of ten must be -30 to 30";
  const auto attribute = built_in_named(quantity.name);
  if (!attribute) return {};
  const auto value = description::to_value(*attribute, quantity.value, quantity.dimension,
                                           description::Side::requirement);
  return value ? std::string() : value.error();
}

bool is_same(const Quantity& a, const Quantity& b) {
  return a.name == b.name && a.dimension.unit == b.dimension.unit && normal(a) == normal(b);
}

std::string to_words(const Quantity& quantity) {
  if (const auto attribute = built_in_named(quantity.name))
    return built_in_words(quantity, *attribute);
  const int magnitude = quantity.dimension.magnitude;
  const auto unit = unit_words(quantity.dimension.unit);
  if (magnitude != 0 && takes_prefix(quantity.dimension.unit) && has_prefix(magnitude))
    return fmt::format("{} {}{}", quantity.value, prefix_of(magnitude), unit);
  const auto number =
      magnitude == 0 ? quantity.value : fmt::format("{} x 10^{}", quantity.value, magnitude);
  return unit.empty() ? number : fmt::format("{} {}", number, unit);
}

std::string_view help_of(Attribute attribute) {
  constexpr auto help = std::to_array<std::string_view>({
      "longest time from sending to receiving, jitter included; ns, us, ms, s",
      "longest minus shortest such time; ns, us, ms, s",
      "time by which an event must be there; ns, us, ms, s",
      "time between two events; ns, us, ms, s",
      "payload in a second; B/s, kB/s, MB/s, bit/s, kbit/s, Mbit/s",
      "share of events that may be lost; %, ppm, ppb",
      "events in a row that may be lost; a number",
      "largest event; a number of bytes, or B, kB, KiB",
  });
  static_assert(help.size() == kAttributes);
  return help.at(index_of(attribute));
}

}  // namespace mlcca::tools::design
