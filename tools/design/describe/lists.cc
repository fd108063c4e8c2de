// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/lists.hpp"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "base/number.hpp"
#include "description/short_form.hpp"

namespace mlcca::tools::design {
namespace {

NewElement parent(std::string name) {
  return {.name = std::move(name), .text = {}, .children = {}, .attributes = {}};
}

std::string text_in(const Markup& markup, const Node* node) {
  return node == nullptr ? std::string() : markup.text_of(*node);
}

/// Converts an integer that the schema has limited.
int whole_in(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return number_in<int>(text).value_or(0);
}

}  // namespace

description::Dimension dimension_of(const Markup& markup, const Node* node) {
  description::Dimension result;
  if (node == nullptr) return result;
  result.magnitude = whole_in(text_in(markup, node->child("Magnitude")));
  const auto* unit = node->child("SIUnit");
  if (unit == nullptr) return result;
  for (std::size_t i = 0; i < kBaseElements.size(); ++i)
    result.unit.at(i) =
        static_cast<std::int8_t>(whole_in(text_in(markup, unit->child(kBaseElements.at(i)))));
  return result;
}

std::vector<Listed> attributes_of(const Markup& markup, const Node& list) {
  std::vector<Listed> out;
  for (const auto& key : list.attributes) {
    const auto attribute = description::with_short_name(key.name);
    if (!attribute) continue;
    const std::string text = markup.text_of(key);
    const auto amount = description::read_short(*attribute, text);
    out.push_back({.quantity = {.name = info(*attribute).name,
                                .value = std::string(amount.decimal),
                                .dimension = amount.dimension},
                   .key = &key,
                   .line = list.line});
  }
  for (const auto& child : list.children)
    if (child.name == "Attribute")
      out.push_back({.quantity = {.name = text_in(markup, child.child("Name")),
                                  .value = text_in(markup, child.child("Value")),
                                  .dimension = dimension_of(markup, child.child("Dimension"))},
                     .element = &child,
                     .line = child.line});
  return out;
}

std::optional<std::string> short_value(std::string_view list, const Quantity& quantity) {
  const auto* const type = description::list_named(list);
  if (type == nullptr) return std::nullopt;
  for (std::size_t i = 0; i < kAttributes; ++i)
    if (quantity.name == kAttributeTable[i].name)
      return description::write_short(*type, attribute_at(i),
                                      {.decimal = quantity.value, .dimension = quantity.dimension});
  return std::nullopt;
}

NewElement leaf(std::string name, std::string text) {
  return {.name = std::move(name), .text = std::move(text), .children = {}, .attributes = {}};
}

NewElement unit_element(const description::Unit& unit) {
  auto result = parent("SIUnit");
  for (std::size_t i = 0; i < unit.size(); ++i)
    if (unit.at(i) != 0)
      result.children.push_back(leaf(kBaseElements.at(i), std::to_string(unit.at(i))));
  return result;
}

NewElement dimension_element(const description::Dimension& dimension) {
  auto result = parent("Dimension");
  if (dimension.unit != description::Unit{})
    result.children.push_back(unit_element(dimension.unit));
  if (dimension.magnitude != 0)
    result.children.push_back(leaf("Magnitude", std::to_string(dimension.magnitude)));
  return result;
}

NewElement attribute_element(const Quantity& quantity) {
  auto result = parent("Attribute");
  result.children.push_back(leaf("Name", quantity.name));
  auto dimension = dimension_element(quantity.dimension);
  if (!dimension.children.empty()) result.children.push_back(std::move(dimension));
  result.children.push_back(leaf("Value", quantity.value));
  return result;
}

}  // namespace mlcca::tools::design
