// SPDX-License-Identifier: BSD-2-Clause
#include "control/attributes.hpp"

namespace mlcca::control {

std::optional<mlcca::Attribute> attribute_named(std::string_view name) {
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (name == kAttributeTable[i].name) return attribute_at(i);
  return std::nullopt;
}

std::vector<Attribute> attributes_of(const AttributeSet& set) {
  std::vector<Attribute> out;
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (const mlcca::Attribute a = attribute_at(i); set.has(a))
      out.push_back(
          {.name = info(a).name, .value = set[a], .unit = info(a).unit, .dynamic = false});
  return out;
}

Result<AttributeSet> set_of(const std::vector<Attribute>& attributes) {
  AttributeSet out;
  for (const Attribute& one : attributes) {
    const auto attribute = attribute_named(one.name);
    if (!attribute) return fail("there is no attribute '" + one.name + "'");
    out.set(*attribute, one.value);
  }
  return out;
}

}  // namespace mlcca::control
