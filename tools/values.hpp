// SPDX-License-Identifier: BSD-2-Clause
// Attribute values for people: "Period=50ms", "400 kB/s", "0.5 %".
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "base/units.hpp"
#include "control/messages.hpp"
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::tools {

/// What a value on the command line states, which determines the side to which it is rounded.
enum class Role : std::uint8_t {
  required,  ///< by a subscriber: rounded so that it is harder to fulfil
  offered,   ///< by a publisher: requirements likewise, traffic rounded towards more traffic
};

/// Parses "Name=Value": a name of mlcca::kAttributeTable and a decimal number with a unit, which is
/// optional only for Omission and MaxPayload. A value that is no multiple of the attribute's unit
/// is rounded as `role` states. An error states what would be right.
Result<control::Attribute> parse_attribute(std::string_view text, Role role);

/// As parse_attribute(), but a name that is not in the table may be an attribute that the
/// description in force defines. It is passed on as written: "Temperature=31.5K" becomes value 315
/// with unit "1e-1 K". The daemon checks the name and the unit.
Result<control::Attribute> parse_stated(std::string_view text, Role role);

/// The unit `name` (which may be empty, if none is needed) for attributes whose unit in the table
/// (AttributeInfo::unit) is `base`; nullptr if they do not have such a unit.
const Unit* unit_of(std::string_view base, std::string_view name);

/// bit/s of a CAN bus: "500000", "500k" or "500 kbit/s", 1000 to `most`; rounded down.
Result<std::uint32_t> parse_bus_rate(std::string_view text, std::uint32_t most);

/// bit/s of "24Mbit/s", "1.5 MB/s", "400 KByte/s" or "54M" (as radios state it); at least 1.
Result<std::uint64_t> parse_bit_rate(std::string_view text, Rounding rounding);

/// The part of `whole` that "0.25" or "25%" states; at most `whole`.
Result<std::uint64_t> parse_share(std::string_view text, std::uint64_t whole, Rounding rounding);

/// ns of a number of microseconds, such as "12.5".
Result<std::uint64_t> parse_microseconds(std::string_view text, Rounding rounding);

/// Exact text of bit/s: "7.542857 Mbit/s".
std::string print_bit_rate(std::uint64_t bits_per_second);

/// A value with its unit: "50 ms". An attribute that is not in mlcca::kAttributeTable is printed in
/// its own unit: "12 apples", and "1.2 apples" for the unit "1e-1 apples".
std::string print_value(std::string_view attribute, std::uint64_t value, std::string_view unit);

/// Text of nanoseconds: "50 ms"; 2^64-1 is "for ever".
std::string print_duration(std::uint64_t ns);

/// Text of bit/s: "500 kbit/s"; 0 is "unknown".
std::string print_bitrate(std::uint32_t bits_per_second);

/// A CAN identifier in the form of candump ("123", "0123abcd"), followed by " RTR" or " error" for
/// such frames.
std::string print_can_id(std::uint32_t can_id);

}  // namespace mlcca::tools
