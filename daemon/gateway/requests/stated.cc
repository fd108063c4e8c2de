// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/stated.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/decimal.hpp"
#include "control/attributes.hpp"
#include "core/model/text.hpp"

namespace mlcca {
namespace {

std::optional<std::size_t> own_named(const core::System& system, std::string_view name) {
  const auto found = std::ranges::find(system.user_attributes, name, &core::UserAttribute::name);
  if (found == system.user_attributes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - system.user_attributes.begin());
}

std::string unknown(const core::System& system, std::string_view name) {
  std::vector<std::string_view> table;
  for (const AttributeInfo& row : kAttributeTable) table.emplace_back(row.name);
  std::vector<std::string_view> own;
  own.reserve(system.user_attributes.size());
  for (const core::UserAttribute& attribute : system.user_attributes)
    own.emplace_back(attribute.name);
  return fmt::format("there is no attribute '{}' (there are: {}; the description defines: {})",
                     name, fmt::join(table, ", "),
                     own.empty() ? "none" : fmt::format("{}", fmt::join(own, ", ")));
}

/// A stated value in the integers of the attribute. The error names the unit.
Result<Value> value_of(const core::UserAttribute& own, const control::Attribute& stated) {
  const core::UserAttribute given = core::of_unit(stated.unit);
  if (given.unit != own.unit)
    return fail(fmt::format("{} is {}; here is {}", own.name,
                            own.unit.empty() ? "a number without a unit" : "stated in " + own.unit,
                            given.unit.empty() ? "no unit" : given.unit));
  const auto number = Decimal::read(std::to_string(stated.value));
  const auto value = number->scaled(given.magnitude - own.magnitude, own.better == Better::larger);
  if (!value) return fail(own.name + " is too large");
  if (own.composition == Composition::survival && *value > kCertainLoss)
    return fail(own.name + " is more than everything: at most 1");
  return *value;
}

void put(core::UserValues& values, const core::UserValue& value) {
  const auto place =
      std::ranges::lower_bound(values, value.attribute, {}, &core::UserValue::attribute);
  if (place != values.end() && place->attribute == value.attribute)
    *place = value;
  else
    values.insert(place, value);
}

}  // namespace

Result<AttributeSet> overridden(AttributeSet base, const core::System& system,
                                const std::vector<control::Attribute>& changes) {
  for (const control::Attribute& change : changes) {
    const auto attribute = control::attribute_named(change.name);
    if (attribute)
      base.set(*attribute, change.value);
    else if (!own_named(system, change.name))
      return fail(unknown(system, change.name));
  }
  return base;
}

Result<core::UserValues> overridden(core::UserValues base, const core::System& system,
                                    const std::vector<control::Attribute>& changes) {
  for (const control::Attribute& change : changes) {
    const auto own = own_named(system, change.name);
    if (!own || control::attribute_named(change.name)) continue;
    const auto value = value_of(system.user_attributes[*own], change);
    if (!value) return std::unexpected(value.error());
    put(base, {.attribute = static_cast<std::uint32_t>(*own), .dynamic = false, .value = *value});
  }
  return base;
}

}  // namespace mlcca
