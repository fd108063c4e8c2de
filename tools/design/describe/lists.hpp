// SPDX-License-Identifier: BSD-2-Clause
// The lists of attributes in a text (<Attributes>, <Provision>, <PerHop>), in the short form (XML
// attributes) and in the paper's (Attribute elements).
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/design/describe/layout.hpp"
#include "tools/design/describe/markup.hpp"
#include "tools/design/describe/quantity.hpp"

namespace mlcca::tools::design {

/// An attribute of a list. Either `element` or `key` is set, according to its form; the other is
/// null.
struct Listed {
  Quantity quantity;
  const Node* element = nullptr;
  const MarkupAttribute* key = nullptr;
  int line = 0;
};

/// All attributes of a list, XML attributes first. The list must be valid by the schema.
std::vector<Listed> attributes_of(const Markup& markup, const Node& list);

/// The value in the short form, in a list of that element name; nullopt if only an element can
/// state it.
std::optional<std::string> short_value(std::string_view list, const Quantity& quantity);

/// The <Attribute> element that states the quantity.
NewElement attribute_element(const Quantity& quantity);

/// The unit and magnitude of a <Dimension> element; `node` null: a number without unit.
description::Dimension dimension_of(const Markup& markup, const Node* node);

/// The element names of the base units, in the order of description::Unit.
inline constexpr std::array<const char*, description::kBaseUnits> kBaseElements = {
    "Seconds", "Bytes", "Metres", "Kilograms", "Amperes", "Kelvins", "Moles", "Candelas"};

NewElement leaf(std::string name, std::string text);
NewElement unit_element(const description::Unit& unit);
NewElement dimension_element(const description::Dimension& dimension);

}  // namespace mlcca::tools::design
