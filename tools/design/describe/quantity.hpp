// SPDX-License-Identifier: BSD-2-Clause
// An attribute as an event-channel file states it: digits, a power of ten and a unit. What a person
// types ("Period=50ms") becomes that without rounding.
#pragma once
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "description/attributes.hpp"

namespace mlcca::tools::design {

struct Quantity {
  std::string name;
  std::string value;  ///< digits, optionally a point and more digits
  description::Dimension dimension;
};

/// "Name=Value" of one of the built-in attributes, as every verb takes it. The digits stay as they
/// were typed: 50ms is 50 with magnitude -3.
Result<Quantity> parse_built_in(std::string_view text);

/// "Name=Value" of an attribute that the user has defined: a decimal number, then a product of
/// units ("21.5 K", "9.81 m/s^2", "3 mm"): the base units s, B, m, kg, A, K, mol, cd, and g, with a
/// prefix n, u, m, k, M or G, and an exponent behind '^'. What follows a '/' is divided by.
Result<Quantity> parse_user_defined(std::string_view text);

/// The name before the equals sign is one of the built-in attributes, whichever letters are large.
bool names_built_in(std::string_view text);

/// What is wrong with the value of a channel; an empty text if nothing. Of an attribute that is not
/// built in, only the form is checked.
std::string problem_of(const Quantity& quantity);

/// The same attribute, value and unit, however they are written: 50 with magnitude -3 is 0.05.
bool is_same(const Quantity& a, const Quantity& b);

/// "50 ms", "9.81 m s^-2"; exact, and for a built-in attribute what parse_built_in() reads.
std::string to_words(const Quantity& quantity);

/// The units that the attribute of that name takes, and what it says: for a question.
std::string_view help_of(Attribute attribute);

}  // namespace mlcca::tools::design
