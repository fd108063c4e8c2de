// SPDX-License-Identifier: BSD-2-Clause
// The short form of a list of attributes: one XML attribute for each built-in attribute, e.g.
// period="50ms". system.xsd says which ones a list may have and how their values are written.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "description/attributes.hpp"
#include "description/grammar.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

constexpr char small(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Whether `key` is `name` with a lower-case first letter.
constexpr bool is_short_of(std::string_view key, std::string_view name) {
  return key.size() == name.size() && key.front() == small(name.front()) &&
         key.substr(1) == name.substr(1);
}

/// The attribute's name in the short form, e.g. "maxPayload" for MaxPayload.
std::string short_name(Attribute attribute);

/// The attribute with the short name `key`; nullopt if there is none.
std::optional<Attribute> with_short_name(std::string_view key);

/// The type of <Attributes>, <Provision> or <PerHop>; null for other elements.
const ElementType* list_named(std::string_view element);

/// The amount that the elements Value and Dimension state in the long form.
struct Amount {
  std::string_view decimal;
  Dimension dimension;
};

/// Parses a value that the schema has accepted: "50ms" of a Period is 50 with Seconds 1 and
/// Magnitude -3. The result refers to `text`.
Amount read_short(Attribute attribute, std::string_view text);

/// The amount as an XML attribute of that list, exactly. If a unit has the amount's magnitude, its
/// digits are kept; otherwise the unit that needs the fewest digits is used. Nullopt if the list
/// has no such XML attribute or no unit can express the amount; then it must remain an element.
std::optional<std::string> write_short(const ElementType& list, Attribute attribute,
                                       const Amount& amount);

}  // namespace mlcca::description
