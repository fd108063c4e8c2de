// SPDX-License-Identifier: BSD-2-Clause
// Lists of attributes in a text: <Attributes>, <Provision> and <PerHop>, in their two forms.
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

/// One attribute of a list: an Attribute element, or an XML attribute in the short form. The other
/// one is null.
struct Listed {
  Quantity quantity;
  const Node* element = nullptr;
  const MarkupAttribute* key = nullptr;
  int line = 0;
};

/// All of a list, XML attributes first. The schema has accepted it.
std::vector<Listed> attributes_of(const Markup& markup, const Node& list);

/// Its value in the short form, in a list of that name; nothing where it stays an element.
std::optional<std::string> short_value(std::string_view list, const Quantity& quantity);

/// The element <Attribute> that states it.
NewElement attribute_element(const Quantity& quantity);

/// The unit and Magnitude that a <Dimension> element states; null: a plain number.
description::Dimension dimension_of(const Markup& markup, const Node* node);

/// The elements of base units, in the order of description::Unit.
inline constexpr std::array<const char*, description::kBaseUnits> kBaseElements = {
    "Seconds", "Bytes", "Metres", "Kilograms", "Amperes", "Kelvins", "Moles", "Candelas"};

NewElement leaf(std::string name, std::string text);
NewElement unit_element(const description::Unit& unit);
NewElement dimension_element(const description::Dimension& dimension);

}  // namespace mlcca::tools::design
