// SPDX-License-Identifier: BSD-2-Clause
// Quantities with units, as the XML has them, into the integers of mlcca/attribute.hpp.
#pragma once
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

#include "description/problems.hpp"
#include "description/xml.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

/// Requirements are rounded to the harder side, provisions to the worse one.
enum class Side : std::uint8_t { requirement, provision };

struct Dimension {
  int seconds = 0;    ///< exponent of the second
  int bytes = 0;      ///< exponent of the byte
  int magnitude = 0;  ///< power of ten, -30..30
};

/// `decimal` (digits, optionally a point and more digits; at most 20 on each side) times
/// 10^magnitude in the unit of the attribute's table row. The error says what would be right: wrong
/// dimension, above 2^64 - 2 units, a loss above one, a Period or Deadline below 1 ns, a Deadline
/// that is provided.
std::expected<Value, std::string> to_value(Attribute attribute, std::string_view decimal,
                                           const Dimension& dimension, Side side);

/// The list of an <Attributes> or <Provision> element. What is wrong, also an attribute that stands
/// there twice, is reported and left out.
AttributeSet read_attributes(const Element& list, Side side, Problems& problems);

/// The attributes of `defaults` with those of `own` in their place.
AttributeSet with_own(const AttributeSet& defaults, const AttributeSet& own);

/// The attribute of that name, or nothing.
const AttributeInfo* attribute_named(std::string_view name);

}  // namespace mlcca::description
