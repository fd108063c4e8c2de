// SPDX-License-Identifier: BSD-2-Clause
// Attribute values as people write and read them: "Period=50ms", "400 kB/s", "0.5 %".
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

/// What a value on the command line states; decides the side to which it is rounded.
enum class Role : std::uint8_t {
  required,  ///< of a subscriber: rounded towards harder
  offered,   ///< of a publisher: requirements towards harder, traffic towards more of it
};

/// Reads "Name=Value": a name of mlcca::kAttributeTable and a decimal number with a unit, which
/// only Omission and MaxPayload may leave out. Exact: what the attribute's own unit cannot hold is
/// rounded as `role` says. The error says what would be right.
Result<control::Attribute> parse_attribute(std::string_view text, Role role);

/// The same; and where the table has no such name, what the description in force may define, as it
/// is written: value and unit of "Temperature=31.5K" are 315 and "1e-1 K". The daemon says whether
/// there is such an attribute and what it is stated in.
Result<control::Attribute> parse_stated(std::string_view text, Role role);

/// The unit `name` (may be empty, where none is needed) of attributes whose own unit is `base`
/// (AttributeInfo::unit); nullptr if they do not take it.
const Unit* unit_of(std::string_view base, std::string_view name);

/// bit/s of "24Mbit/s", "1.5 MB/s", "400 KByte/s" or, as radios are called, "54M". 1 or more.
Result<std::uint64_t> parse_bit_rate(std::string_view text, Rounding rounding);

/// Parts of `whole` in "0.25" or "25%", at most all of it.
Result<std::uint64_t> parse_share(std::string_view text, std::uint64_t whole, Rounding rounding);

/// ns of "12.5", a number of microseconds.
Result<std::uint64_t> parse_microseconds(std::string_view text, Rounding rounding);

/// "7.542857 Mbit/s" of bit/s, exactly.
std::string print_bit_rate(std::uint64_t bits_per_second);

/// "50 ms"; for an attribute that is not in mlcca::kAttributeTable "12 apples", and "1.2 apples" of
/// the unit "1e-1 apples".
std::string print_value(std::string_view attribute, std::uint64_t value, std::string_view unit);

/// "50 ms" of nanoseconds, "for ever" of 2^64-1.
std::string print_duration(std::uint64_t ns);

/// "500 kbit/s", "unknown" of 0.
std::string print_bitrate(std::uint32_t bits_per_second);

/// Identifier as candump prints it ("123", "0123abcd"), then " RTR" or " error" where it is one.
std::string print_can_id(std::uint32_t can_id);

}  // namespace mlcca::tools
