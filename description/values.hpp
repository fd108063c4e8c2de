// SPDX-License-Identifier: BSD-2-Clause
// The simple types of system.xsd, i.e. what a value must be like. make-grammar generates the table
// from the schema; here are its form and the functions that read it.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {

/// A set of bytes.
class Characters {
 public:
  consteval explicit Characters(std::string_view members) {
    for (const char c : members) in_[static_cast<unsigned char>(c)] = true;
  }
  [[nodiscard]] constexpr bool has(char c) const { return in_[static_cast<unsigned char>(c)]; }

 private:
  std::array<bool, 256> in_{};
};

/// A run of characters of one set, as long as possible up to `most`; at least `least`.
struct Run {
  const Characters* of = nullptr;
  std::uint32_t least = 0;
  std::uint32_t most = 0;
};

/// Runs that follow one another.
using Form = std::span<const Run>;

/// How a decimal is converted to an integer: in units of 10^-digits.
struct Scale {
  int digits = 0;
  Rounding rounding = Rounding::down;  ///< towards the safe side
  Value least = 0;                     ///< inclusive, as is `most`
  Value most = 0;
  std::string_view range;  ///< the range in words
};

/// One simple type. Exactly one of `forms`, `values`, `integer` and `longest` defines its values.
struct ValueType {
  std::string_view name;        ///< name in the schema
  std::string_view words;       ///< "it must be ...", for `forms` and integers
  std::string_view pattern;     ///< the pattern in the schema from which `forms` was made; empty
                                ///< without one
  std::span<const Form> forms;  ///< alternatives
  std::span<const std::string_view> values;  ///< the words of an enumeration
  bool integer = false;
  long least = 0;  ///< of an integer, inclusive
  long most = 0;
  std::size_t shortest = 0;  ///< in characters
  std::size_t longest = 0;   ///< in characters
  Scale scale;               ///< for a decimal with a range
};

/// The types that are used outside of the table, by their names in the schema.
namespace type {
extern const ValueType kArrival, kAttributeName, kDecimal, kName, kNodeAddress, kSafeSide,
    kSetPriority, kSubject, kText, kUserName;
}  // namespace type

/// All types of the table. Tests compare each of them with the schema.
std::span<const ValueType* const> value_types();

/// Whether the schema accepts `value`, whose white space must be collapsed.
bool is_valid(const ValueType& type, std::string_view value);

/// The text for a value that is not valid: what is wrong, and what would be right.
std::string explain(const ValueType& type, std::string_view value);

}  // namespace mlcca::description
