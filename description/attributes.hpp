// SPDX-License-Identifier: BSD-2-Clause
// Converts quantities with units, as the XML states them, to the integers of mlcca/attribute.hpp.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/system.hpp"
#include "description/problems.hpp"
#include "description/xml.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

/// The direction of rounding: requirements towards harder, provisions towards worse.
enum class Side : std::uint8_t { requirement, provision };

/// Exponents of the base units in the order of the schema: seconds, bytes, metres, kilograms,
/// amperes, kelvins, moles, candelas.
inline constexpr std::size_t kBaseUnits = 8;
using Unit = std::array<std::int8_t, kBaseUnits>;

/// The unit and the power of ten of a quantity.
struct Dimension {
  Unit unit{};
  int magnitude = 0;  ///< power of ten, -30 to 30
};

/// The unit and magnitude of the attribute's integers, e.g. Seconds 1 and -9 for Period.
Dimension inside(Attribute attribute);

/// Texts for problems: why no provision can state the attribute, and why no PerHop can.
std::string not_provided_words(std::string_view name);
std::string of_links_words(std::string_view name);

/// The unit as text, e.g. "s^-1 bytes"; empty for a plain number.
std::string unit_words(const Unit& unit);

/// The unit and magnitude of a <Dimension> element; null means a plain number.
Dimension read_dimension(const Element* dimension);

/// Converts `decimal` (digits with an optional point; at most 20 on each side) times 10^magnitude
/// to the unit of the attribute's integers. The error says what would be right: for a wrong
/// dimension, an amount above 2^64 - 2 units, a loss above one, a Period or Deadline below 1 ns, or
/// a Deadline in a provision. It quotes the amount as `written`, or if that is empty as Value and
/// Magnitude.
std::expected<Value, std::string> to_value(Attribute attribute, std::string_view decimal,
                                           const Dimension& dimension, Side side,
                                           std::string_view written = {});

/// A value of an attribute that is not built in. Its meaning is known only when all of the
/// description has been read.
struct UserValueDraft {
  std::string name;
  std::string decimal;
  Dimension dimension;
  bool dynamic = false;
  core::Origin origin;
};

/// Reads an <Attributes>, <Provision> or <PerHop> element in its long or short form. Returns the
/// built-in attributes, and adds the others to `user`. What is wrong, including an attribute that
/// is stated twice, is reported and left out.
AttributeSet read_attributes(const Element& list, Side side, Problems& problems,
                             std::vector<UserValueDraft>& user);

/// A user-defined attribute and the unit of its values.
struct KnownUserAttribute {
  const core::UserAttribute* attribute = nullptr;
  Unit unit{};
};

/// Converts values to the steps of their user-defined attributes, rounded as `side` says. Unknown
/// attributes and wrong values are reported and left out.
core::UserValues user_values(const std::vector<UserValueDraft>& drafts,
                             const std::vector<KnownUserAttribute>& known, Side side,
                             Problems& problems);

/// The attributes of `defaults`, overridden by those of `own`.
AttributeSet with_own(const AttributeSet& defaults, const AttributeSet& own);
core::UserValues with_own(const core::UserValues& defaults, const core::UserValues& own);

/// The built-in attribute of that name, or null.
const AttributeInfo* attribute_named(std::string_view name);

}  // namespace mlcca::description
