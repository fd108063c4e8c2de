// SPDX-License-Identifier: BSD-2-Clause
// Exact decimal arithmetic on digits: the point is moved, then the rest decides the rounding.
#include "description/attributes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <optional>

namespace mlcca::description {
namespace {

/// What the units of the attribute table are made of.
struct Unit {
  std::string_view name;  ///< as in AttributeInfo::unit
  int seconds;
  int bytes;
  int scale;  ///< units in one of the SI unit, as a power of ten
  std::string_view right;
};

constexpr auto kUnits = std::to_array<Unit>({
    {"ns", 1, 0, 9, "is a time: it needs <SIUnit><Seconds>1</Seconds></SIUnit>"},
    {"bytes/s", -1, 1, 0,
     "is a rate: it needs <SIUnit><Seconds>-1</Seconds><Bytes>1</Bytes></SIUnit>"},
    {"1e-9", 0, 0, 9, "is a fraction: it has no SIUnit, only a Magnitude such as -3"},
    {"events", 0, 0, 0, "is a number of events: it has no SIUnit"},
    {"bytes", 0, 1, 0, "is a size: it needs <SIUnit><Bytes>1</Bytes></SIUnit>"},
});

constexpr bool every_unit_is_known() {
  return std::ranges::all_of(kAttributeTable, [](const AttributeInfo& row) {
    return std::ranges::find(kUnits, std::string_view(row.unit), &Unit::name) != kUnits.end();
  });
}
static_assert(every_unit_is_known());

const Unit& unit_of(Attribute attribute) {
  return *std::ranges::find(kUnits, std::string_view(info(attribute).unit), &Unit::name);
}

std::string dimension_words(const Dimension& dimension) {
  if (dimension.seconds == 0 && dimension.bytes == 0) return "no SIUnit";
  std::string out;
  if (dimension.seconds != 0) out += fmt::format("Seconds {}", dimension.seconds);
  if (dimension.bytes != 0)
    out += fmt::format("{}Bytes {}", out.empty() ? "" : ", ", dimension.bytes);
  return out;
}

/// Nothing if it does not fit below kUnbounded.
std::optional<Value> whole(std::string_view digits) {
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  if (digits.empty()) return Value{0};
  Value value = 0;
  const auto [stop, error] = std::from_chars(digits.begin(), digits.end(), value);
  if (error != std::errc{} || stop != digits.end() || value == kUnbounded) return std::nullopt;
  return value;
}

/// decimal * 10^shift, rounded up or down.
std::optional<Value> shifted(std::string_view decimal, int shift, bool up) {
  const auto point = std::min(decimal.find('.'), decimal.size());
  std::string digits(decimal.substr(0, point));
  if (point < decimal.size()) digits += decimal.substr(point + 1);
  const auto cut = static_cast<int>(point) + shift;
  const auto kept = static_cast<std::size_t>(std::max(cut, 0));
  if (kept > digits.size()) digits.append(kept - digits.size(), '0');
  const auto value = whole(std::string_view(digits).substr(0, kept));
  const bool exact = digits.find_first_not_of('0', kept) == std::string::npos;
  if (!value || exact || !up) return value;
  return *value + 1 == kUnbounded ? std::nullopt : std::optional(*value + 1);
}

int exponent(const Element* parent, std::string_view name) {
  const auto* element = parent == nullptr ? nullptr : parent->child(name);
  if (element == nullptr) return 0;
  std::string_view text = element->text;
  if (text.starts_with('+')) text.remove_prefix(1);
  int value = 0;  // the schema has bounded it
  std::from_chars(text.begin(), text.end(), value);
  return value;
}

Dimension read_dimension(const Element* dimension) {
  const auto* unit = dimension == nullptr ? nullptr : dimension->child("SIUnit");
  return {.seconds = exponent(unit, "Seconds"),
          .bytes = exponent(unit, "Bytes"),
          .magnitude = exponent(dimension, "Magnitude")};
}

}  // namespace

std::expected<Value, std::string> to_value(Attribute attribute, std::string_view decimal,
                                           const Dimension& dimension, Side side) {
  const auto& row = info(attribute);
  const auto& unit = unit_of(attribute);
  if (side == Side::provision && row.composition == Composition::not_provided)
    return std::unexpected(fmt::format(
        "{} is not provided by anybody: it is held against the Latency; state that", row.name));
  if (dimension.seconds != unit.seconds || dimension.bytes != unit.bytes)
    return std::unexpected(
        fmt::format("{} {}; here is {}", row.name, unit.right, dimension_words(dimension)));
  const bool up = (side == Side::provision) == (row.better == Better::smaller);
  const auto value = shifted(decimal, dimension.magnitude + unit.scale, up);
  if (!value)
    return std::unexpected(fmt::format("{} {} with Magnitude {} is too large: at most {} {}",
                                       row.name, decimal, dimension.magnitude, kUnbounded - 1,
                                       row.unit));
  if (attribute == Attribute::packet_loss && *value > kCertainLoss)
    return std::unexpected(fmt::format("{} {} with Magnitude {} is more than everything: at most 1",
                                       row.name, decimal, dimension.magnitude));
  const bool positive = attribute == Attribute::period || attribute == Attribute::deadline;
  if (positive && *value == 0)
    return std::unexpected(fmt::format("{} must be at least 1 ns; {} with Magnitude {} is less",
                                       row.name, decimal, dimension.magnitude));
  return *value;
}

AttributeSet read_attributes(const Element& list, Side side, Problems& problems) {
  AttributeSet set;
  for (const auto& element : list.children) {
    const auto* name = element.child("Name");
    const auto* value = element.child("Value");
    const auto* row = name == nullptr ? nullptr : attribute_named(name->text);
    if (row == nullptr || value == nullptr) continue;  // the schema has refused it
    const auto attribute = attribute_at(static_cast<std::size_t>(row - kAttributeTable));
    if (set.has(attribute)) {
      problems.add(element.line, element.name,
                   fmt::format("{} stands here a second time: state it once", row->name));
      continue;
    }
    const auto dimension = read_dimension(element.child("Dimension"));
    const auto result = to_value(attribute, value->text, dimension, side);
    const auto dynamic = element.attribute("dynamic");
    if (result)
      set.set(attribute, *result, dynamic == "true" || dynamic == "1");
    else
      problems.add(element.line, element.name, result.error());
  }
  return set;
}

AttributeSet with_own(const AttributeSet& defaults, const AttributeSet& own) {
  auto set = defaults;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto attribute = attribute_at(i);
    if (own.has(attribute)) set.set(attribute, own[attribute], own.is_dynamic(attribute));
  }
  return set;
}

const AttributeInfo* attribute_named(std::string_view name) {
  const auto* row =
      std::ranges::find_if(kAttributeTable, [&](const AttributeInfo& i) { return name == i.name; });
  return row == std::end(kAttributeTable) ? nullptr : row;
}

}  // namespace mlcca::description
