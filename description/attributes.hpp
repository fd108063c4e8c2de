// SPDX-License-Identifier: BSD-2-Clause
// Quantities with units, as the XML has them, into the integers of mlcca/attribute.hpp.
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

/// Requirements are rounded to the harder side, provisions to the worse one.
enum class Side : std::uint8_t { requirement, provision };

/// Exponents of the base units, in the order of the schema: seconds, bytes, metres, kilograms,
/// amperes, kelvins, moles, candelas.
inline constexpr std::size_t kBaseUnits = 8;
using Unit = std::array<std::int8_t, kBaseUnits>;

struct Dimension {
  Unit unit{};
  int magnitude = 0;  ///< power of ten, -30..30
};

/// The unit and magnitude of the attribute's integers: Seconds 1 and -9 of a Period.
Dimension inside(Attribute attribute);

/// Why no provision has it, and why no PerHop has it.
std::string not_provided_words(std::string_view name);
std::string of_links_words(std::string_view name);

/// "s^-1 bytes"; empty for a plain number.
std::string unit_words(const Unit& unit);

/// The unit and magnitude of a <Dimension> element; null: a plain number.
Dimension read_dimension(const Element* dimension);

/// `decimal` (digits, optionally a point and more digits; at most 20 on each side) times
/// 10^magnitude in the unit of the attribute's table row. The error says what would be right: wrong
/// dimension, above 2^64 - 2 units, a loss above one, a Period or Deadline below 1 ns, a Deadline
/// that is provided. It shows the amount as `written`, or without that as Value and Magnitude.
std::expected<Value, std::string> to_value(Attribute attribute, std::string_view decimal,
                                           const Dimension& dimension, Side side,
                                           std::string_view written = {});

/// A value whose attribute is not built in: what it means is known when the description has been
/// read to its end.
struct UserValueDraft {
  std::string name;
  std::string decimal;
  Dimension dimension;
  bool dynamic = false;
  core::Origin origin;
};

/// The list of an <Attributes>, <Provision> or <PerHop> element, in either form: the built-in
/// attributes, and into `user` the others. What is wrong, also an attribute that stands there
/// twice, is reported and left out.
AttributeSet read_attributes(const Element& list, Side side, Problems& problems,
                             std::vector<UserValueDraft>& user);

/// A user-defined attribute and the unit that its values have.
struct KnownUserAttribute {
  const core::UserAttribute* attribute = nullptr;
  Unit unit{};
};

/// The values in the attribute's own steps, rounded as `side` says. What is not known, or wrong, is
/// reported and left out.
core::UserValues user_values(const std::vector<UserValueDraft>& drafts,
                             const std::vector<KnownUserAttribute>& known, Side side,
                             Problems& problems);

/// The attributes of `defaults` with those of `own` in their place.
AttributeSet with_own(const AttributeSet& defaults, const AttributeSet& own);
core::UserValues with_own(const core::UserValues& defaults, const core::UserValues& own);

/// The attribute of that name, or nothing.
const AttributeInfo* attribute_named(std::string_view name);

}  // namespace mlcca::description
