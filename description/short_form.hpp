// SPDX-License-Identifier: BSD-2-Clause
// The short form of a list: an XML attribute for each built-in attribute, such as period="50ms".
// Which there are in which list, and what their values look like, is what system.xsd says.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "description/attributes.hpp"
#include "description/grammar.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

constexpr char small(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// `key` is `name` with a small first letter.
constexpr bool is_short_of(std::string_view key, std::string_view name) {
  return key.size() == name.size() && key.front() == small(name.front()) &&
         key.substr(1) == name.substr(1);
}

/// The name that the attribute has in the short form: "maxPayload" of MaxPayload.
std::string short_name(Attribute attribute);

/// The attribute that has the short name `key`.
std::optional<Attribute> with_short_name(std::string_view key);

/// The type of <Attributes>, <Provision> or <PerHop>; null: that element is no list of attributes.
const ElementType* list_named(std::string_view element);

/// What the elements Value and Dimension would state.
struct Amount {
  std::string_view decimal;
  Dimension dimension;
};

/// "50ms" of a Period: 50, with Seconds 1 and Magnitude -3. The schema has accepted the text, which
/// the result refers to.
Amount read_short(Attribute attribute, std::string_view text);

/// The amount as an XML attribute of that list, exactly: the digits as they stand if a unit has the
/// magnitude, otherwise in the unit in which they are the fewest. Nothing where the list has no
/// such XML attribute or no unit says it: the amount then stays an element.
std::optional<std::string> write_short(const ElementType& list, Attribute attribute,
                                       const Amount& amount);

}  // namespace mlcca::description
