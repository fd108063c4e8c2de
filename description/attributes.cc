// SPDX-License-Identifier: BSD-2-Clause
// Checks the unit of a quantity, then converts its decimal to the integers of its attribute.
#include "description/attributes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/decimal.hpp"
#include "description/convert.hpp"
#include "description/short_form.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {
namespace {

struct BaseUnit {
  std::string_view element;
  std::string_view symbol;
};
constexpr std::array<BaseUnit, kBaseUnits> kBaseUnitTable = {{{"Seconds", "s"},
                                                              {"Bytes", "bytes"},
                                                              {"Metres", "m"},
                                                              {"Kilograms", "kg"},
                                                              {"Amperes", "A"},
                                                              {"Kelvins", "K"},
                                                              {"Moles", "mol"},
                                                              {"Candelas", "cd"}}};

/// A unit of the attribute table, in base units.
struct TableUnit {
  std::string_view name;  ///< as in AttributeInfo::unit
  Unit unit;
  int scale;  ///< integer units in one SI unit, as a power of ten
  std::string_view right;
};

constexpr auto kUnits = std::to_array<TableUnit>({
    {"ns", {1}, 9, "is a time: it needs <SIUnit><Seconds>1</Seconds></SIUnit>"},
    {"bytes/s",
     {-1, 1},
     0,
     "is a rate: it needs <SIUnit><Seconds>-1</Seconds><Bytes>1</Bytes></SIUnit>"},
    {"1e-9", {}, 9, "is a fraction: it has no SIUnit, only a Magnitude such as -3"},
    {"events", {}, 0, "is a number of events: it has no SIUnit"},
    {"bytes", {0, 1}, 0, "is a size: it needs <SIUnit><Bytes>1</Bytes></SIUnit>"},
});

constexpr bool every_unit_is_known() {
  return std::ranges::all_of(kAttributeTable, [](const AttributeInfo& row) {
    return std::ranges::find(kUnits, std::string_view(row.unit), &TableUnit::name) != kUnits.end();
  });
}
static_assert(every_unit_is_known());

const TableUnit& unit_of(Attribute attribute) {
  return *std::ranges::find(kUnits, std::string_view(info(attribute).unit), &TableUnit::name);
}

/// The unit as the XML elements state it: "Seconds 1, Bytes -1".
std::string dimension_words(const Unit& unit) {
  std::string out;
  for (std::size_t i = 0; i < kBaseUnits; ++i)
    if (unit[i] != 0)
      out += fmt::format("{}{} {}", out.empty() ? "" : ", ", kBaseUnitTable[i].element, unit[i]);
  return out.empty() ? "no SIUnit" : out;
}

bool rounds_up(Side side, Better better) {
  return (side == Side::provision) == (better == Better::smaller);
}

/// `decimal`, which the schema has accepted, times a power of ten, rounded up or down to an
/// integer; nullopt if that does not fit a Value.
std::optional<Value> scaled(std::string_view decimal, int power, bool up) {
  const auto number = Decimal::read(decimal);
  return number ? number->scaled(power, up) : std::nullopt;
}

std::string twice_words(std::string_view name) {
  return fmt::format("{} stands here a second time: state it once", name);
}

int exponent(const Element* parent, std::string_view name) {
  const auto* element = parent == nullptr ? nullptr : parent->child(name);
  if (element == nullptr) return 0;
  return number<int>(element->text);
}

}  // namespace

std::string unit_words(const Unit& unit) {
  std::string out;
  for (std::size_t i = 0; i < kBaseUnits; ++i) {
    if (unit[i] == 0) continue;
    out += fmt::format("{}{}", out.empty() ? "" : " ", kBaseUnitTable[i].symbol);
    if (unit[i] != 1) out += fmt::format("^{}", unit[i]);
  }
  return out;
}

Dimension read_dimension(const Element* dimension) {
  Dimension out;
  if (dimension == nullptr) return out;
  out.magnitude = exponent(dimension, "Magnitude");
  if (const auto* unit = dimension->child("SIUnit"))
    for (std::size_t i = 0; i < kBaseUnits; ++i)
      out.unit[i] = static_cast<std::int8_t>(exponent(unit, kBaseUnitTable[i].element));
  return out;
}

Dimension inside(Attribute attribute) {
  const auto& unit = unit_of(attribute);
  return {.unit = unit.unit, .magnitude = -unit.scale};
}

std::string not_provided_words(std::string_view name) {
  return fmt::format(
      "{} is provided by no network and no gateway: it is held against the Latency; state that",
      name);
}

std::string of_links_words(std::string_view name) {
  return fmt::format(
      "{} is not stated per hop: it follows from the links and packet-bytes of the Mesh", name);
}

std::expected<Value, std::string> to_value(Attribute attribute, std::string_view decimal,
                                           const Dimension& dimension, Side side,
                                           std::string_view written) {
  const auto& row = info(attribute);
  const auto& unit = unit_of(attribute);
  const auto shown = [&] {
    return written.empty() ? fmt::format("{} with Magnitude {}", decimal, dimension.magnitude)
                           : std::string(written);
  };
  if (side == Side::provision && row.composition == Composition::not_provided)
    return std::unexpected(not_provided_words(row.name));
  if (dimension.unit != unit.unit)
    return std::unexpected(
        fmt::format("{} {}; here is {}", row.name, unit.right, dimension_words(dimension.unit)));
  const auto value = scaled(decimal, dimension.magnitude + unit.scale, rounds_up(side, row.better));
  if (!value)
    return std::unexpected(fmt::format("{} {} is too large: at most {} {}", row.name, shown(),
                                       kUnbounded - 1, row.unit));
  if (attribute == Attribute::packet_loss && *value > kCertainLoss)
    return std::unexpected(
        fmt::format("{} {} is more than everything: at most 1", row.name, shown()));
  const bool positive = attribute == Attribute::period || attribute == Attribute::deadline;
  if (positive && *value == 0)
    return std::unexpected(fmt::format("{} must be at least 1 ns; {} is less", row.name, shown()));
  return *value;
}

AttributeSet read_attributes(const Element& list, Side side, Problems& problems,
                             std::vector<UserValueDraft>& user) {
  AttributeSet set;
  const bool all_dynamic = is_true(list, "dynamic");
  for (const auto& [key, text] : list.attributes) {
    const auto attribute = with_short_name(key);
    if (!attribute) continue;
    const auto [decimal, dimension] = read_short(*attribute, text);
    if (const auto result = to_value(*attribute, decimal, dimension, side, text))
      set.set(*attribute, *result, all_dynamic);
    else
      problems.add(list.origin(), list.name, fmt::format("attribute {}: {}", key, result.error()),
                   core::FindingId::not_in_schema);
  }
  for (const auto& element : list.children) {
    const auto* name = element.child("Name");
    const auto* value = element.child("Value");
    if (name == nullptr || value == nullptr) continue;  // the schema has refused it
    const auto dimension = read_dimension(element.child("Dimension"));
    const bool dynamic = all_dynamic || is_true(element, "dynamic");
    const auto* row = attribute_named(name->text);
    if (row == nullptr) {
      user.push_back({std::string(name->text), std::string(value->text), dimension, dynamic,
                      element.origin()});
      continue;
    }
    const auto attribute = attribute_at(static_cast<std::size_t>(row - kAttributeTable));
    if (set.has(attribute)) {
      problems.add(element.origin(), element.name, twice_words(row->name),
                   core::FindingId::name_twice);
      continue;
    }
    if (const auto result = to_value(attribute, value->text, dimension, side))
      set.set(attribute, *result, dynamic);
    else
      problems.add(element.origin(), element.name, result.error(), core::FindingId::not_in_schema);
  }
  return set;
}

namespace {

std::string unknown_attribute(std::string_view name, const std::vector<KnownUserAttribute>& known) {
  std::vector<std::string_view> names;
  for (const auto& row : kAttributeTable) names.emplace_back(row.name);
  for (const auto& row : known) names.emplace_back(row.attribute->name);
  const auto close = closest(name, names);
  return fmt::format("'{}' is not one of {}{}", name, fmt::join(names, ", "),
                     close.empty() ? "" : fmt::format("; did you mean {}?", close));
}

std::expected<Value, std::string> to_user_value(const UserValueDraft& draft,
                                                const KnownUserAttribute& known, Side side) {
  const auto& attribute = *known.attribute;
  if (draft.dimension.unit != known.unit)
    return std::unexpected(fmt::format("{} has {}; here is {}", attribute.name,
                                       dimension_words(known.unit),
                                       dimension_words(draft.dimension.unit)));
  const auto value = scaled(draft.decimal, draft.dimension.magnitude - attribute.magnitude,
                            rounds_up(side, attribute.better));
  if (!value)
    return std::unexpected(
        fmt::format("{} {} with Magnitude {} is too large: at most {} times "
                    "10^{}",
                    attribute.name, draft.decimal, draft.dimension.magnitude, kUnbounded - 1,
                    attribute.magnitude));
  if (attribute.composition == Composition::survival && *value > kCertainLoss)
    return std::unexpected(fmt::format("{} {} with Magnitude {} is more than everything: at most 1",
                                       attribute.name, draft.decimal, draft.dimension.magnitude));
  return *value;
}

}  // namespace

core::UserValues user_values(const std::vector<UserValueDraft>& drafts,
                             const std::vector<KnownUserAttribute>& known, Side side,
                             Problems& problems) {
  core::UserValues out;
  for (const auto& draft : drafts) {
    const auto found = std::ranges::find_if(
        known, [&](const KnownUserAttribute& k) { return k.attribute->name == draft.name; });
    if (found == known.end()) {
      problems.add(draft.origin, "Name", unknown_attribute(draft.name, known),
                   core::FindingId::unknown_name);
      continue;
    }
    const auto number = static_cast<std::uint32_t>(found - known.begin());
    if (std::ranges::find(out, number, &core::UserValue::attribute) != out.end()) {
      problems.add(draft.origin, "Attribute", twice_words(draft.name), core::FindingId::name_twice);
      continue;
    }
    if (const auto value = to_user_value(draft, *found, side))
      out.push_back({number, draft.dynamic, *value});
    else
      problems.add(draft.origin, "Attribute", value.error(), core::FindingId::not_in_schema);
  }
  std::ranges::sort(out, {}, &core::UserValue::attribute);
  return out;
}

AttributeSet with_own(const AttributeSet& defaults, const AttributeSet& own) {
  auto set = defaults;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto attribute = attribute_at(i);
    if (own.has(attribute)) set.set(attribute, own[attribute], own.is_dynamic(attribute));
  }
  return set;
}

core::UserValues with_own(const core::UserValues& defaults, const core::UserValues& own) {
  core::UserValues out = own;
  for (const auto& value : defaults)
    if (std::ranges::find(own, value.attribute, &core::UserValue::attribute) == own.end())
      out.push_back(value);
  std::ranges::sort(out, {}, &core::UserValue::attribute);
  return out;
}

const AttributeInfo* attribute_named(std::string_view name) {
  const auto* row =
      std::ranges::find_if(kAttributeTable, [&](const AttributeInfo& i) { return name == i.name; });
  return row == std::end(kAttributeTable) ? nullptr : row;
}

}  // namespace mlcca::description
