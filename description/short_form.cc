// SPDX-License-Identifier: BSD-2-Clause
#include "description/short_form.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/decimal.hpp"
#include "base/units.hpp"
#include "description/values.hpp"

namespace mlcca::description {
namespace {

/// The units of the attribute that are powers of ten of its integer unit.
std::vector<const mlcca::Unit*> units_of(Attribute attribute) {
  const Measure measure = units::measure_of(info(attribute).unit);
  std::vector<const mlcca::Unit*> out;
  for (const auto table : {std::span<const mlcca::Unit>(units::kAll),
                           std::span<const mlcca::Unit>(units::kPlainShares)})
    for (const auto& unit : table)
      if (unit.measure == measure && unit.factor == 1) out.push_back(&unit);
  return out;
}

const mlcca::Unit* unit_named(Measure measure, std::string_view name) {
  const auto* const found = units::find(measure, name);
  return found != nullptr ? found : units::find(measure, name, units::kPlainShares);
}

const ValueType* type_of(const ElementType& list, Attribute attribute) {
  for (const auto& key : list.keys)
    if (is_short_of(key.name, info(attribute).name)) return key.type;
  return nullptr;
}

}  // namespace

std::string short_name(Attribute attribute) {
  std::string out = info(attribute).name;
  out.front() = small(out.front());
  return out;
}

std::optional<Attribute> with_short_name(std::string_view key) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (is_short_of(key, kAttributeTable[i].name)) return attribute_at(i);
  return std::nullopt;
}

const ElementType* list_named(std::string_view element) {
  // The types have the same names as their elements.
  if (element != "Attributes" && element != "Provision" && element != "PerHop") return nullptr;
  const auto types = element_types();
  const auto found = std::ranges::find(types, element, &ElementType::name);
  return found == types.end() ? nullptr : *found;
}

Amount read_short(Attribute attribute, std::string_view text) {
  const auto end = std::min(text.find_first_not_of("0123456789."), text.size());
  Amount out{.decimal = text.substr(0, end), .dimension = inside(attribute)};
  const auto* const unit = unit_named(units::measure_of(info(attribute).unit), text.substr(end));
  if (unit != nullptr) out.dimension.magnitude += unit->power;
  return out;
}

std::optional<std::string> write_short(const ElementType& list, Attribute attribute,
                                       const Amount& amount) {
  const auto* const type = type_of(list, attribute);
  const auto number = Decimal::read(amount.decimal);
  const auto own = inside(attribute);
  if (type == nullptr || !number || amount.dimension.unit != own.unit) return std::nullopt;
  std::optional<std::string> shortest;
  for (const auto* unit : units_of(attribute)) {
    const int power = amount.dimension.magnitude - own.magnitude - unit->power;
    if (power == 0) {
      auto as_written = std::string(amount.decimal) + std::string(unit->name);
      if (is_valid(*type, as_written)) return as_written;
    }
    auto moved = number->times_power(power).text() + std::string(unit->name);
    if (is_valid(*type, moved) && (!shortest || moved.size() < shortest->size()))
      shortest = std::move(moved);
  }
  return shortest;
}

}  // namespace mlcca::description
