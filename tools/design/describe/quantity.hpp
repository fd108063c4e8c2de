// SPDX-License-Identifier: BSD-2-Clause
// An attribute value as an event-channel file states it: digits, a power of ten and a unit. Text
// that a person types ("Period=50ms") is converted into it without rounding.
#pragma once
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "description/attributes.hpp"

namespace mlcca::tools::design {

/// An attribute with its value and dimension.
struct Quantity {
  std::string name;
  std::string value;  ///< digits, optionally with a decimal point
  description::Dimension dimension;
};

/// Parses "Name=Value" of a built-in attribute, in the form of all verbs. The digits are kept: 50ms
/// is 50 with magnitude -3.
Result<Quantity> parse_built_in(std::string_view text);

/// Parses "Name=Value" of a user-defined attribute: a decimal number and a product of units ("21.5
/// K", "9.81 m/s^2", "3 mm"). Units are s, B, m, kg, A, K, mol, cd and g, with an optional prefix
/// n, u, m, k, M or G and an exponent behind '^'. Units behind a '/' divide.
Result<Quantity> parse_user_defined(std::string_view text);

/// Whether the name before the equals sign is a built-in attribute, regardless of case.
bool names_built_in(std::string_view text);

/// What is wrong with the value; empty if nothing is. For an attribute that is not built in only
/// the form is checked.
std::string problem_of(const Quantity& quantity);

/// Whether both are the same attribute, value and unit, in whatever notation: 50 with magnitude -3
/// equals 0.05.
bool is_same(const Quantity& a, const Quantity& b);

/// Exact text: "50 ms", "9.81 m s^-2". parse_built_in() can read that of a built-in attribute.
std::string to_words(const Quantity& quantity);

/// The units and meaning of an attribute, for a question to the user.
std::string_view help_of(Attribute attribute);

}  // namespace mlcca::tools::design
