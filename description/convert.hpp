// SPDX-License-Identifier: BSD-2-Clause
// Converts texts that the schema has accepted to numbers, strings and truth values.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/number.hpp"
#include "description/xml.hpp"

namespace mlcca::description {

/// Parses a decimal number, or a hexadecimal one after 0x. The schema has limited the digits to
/// what fits.
template <class Number>
Number number(std::string_view text) {
  if (text.starts_with("0x"))
    return number_in<Number>(text.substr(2), kHexadecimalBase).value_or(Number{});
  if (text.starts_with('+')) text.remove_prefix(1);
  return number_in<Number>(text).value_or(Number{});
}

inline std::optional<unsigned> optional_number(std::string_view text) {
  if (text.empty()) return std::nullopt;
  return number<unsigned>(text);
}

/// The number that an attribute states; `otherwise` if it is absent.
template <class Number>
Number number_or(const Element& element, std::string_view attribute, Number otherwise) {
  const auto text = element.attribute(attribute);
  return text.empty() ? otherwise : number<Number>(text);
}

/// The number that an attribute states, or its default in the schema.
template <class Number>
Number number_of(const Element& element, std::string_view attribute) {
  return number<Number>(element.valued(attribute));
}

inline bool is_true(std::string_view text) { return text == "true" || text == "1"; }

/// The truth value that an attribute states, or its default in the schema.
inline bool is_true(const Element& element, std::string_view attribute) {
  return is_true(element.valued(attribute));
}

inline std::string text_of(const Element* element) {
  return element == nullptr ? std::string() : std::string(element->text);
}

inline std::string text_of(const Element& element, std::string_view attribute) {
  return std::string(element.attribute(attribute));
}

}  // namespace mlcca::description
