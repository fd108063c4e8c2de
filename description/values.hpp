// SPDX-License-Identifier: BSD-2-Clause
// The simple types of system.xsd: what a value looks like. The table is made of the schema
// (make-grammar); here are its form and what it is read with.
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

/// Characters of a set, one after the other: as many as there are, up to `most`.
struct Run {
  const Characters* of = nullptr;
  std::uint32_t least = 0;
  std::uint32_t most = 0;
};

/// Runs, one after the other.
using Form = std::span<const Run>;

/// What a decimal becomes: a whole number of 10^-digits.
struct Scale {
  int digits = 0;
  Rounding rounding = Rounding::down;  ///< to the safe side
  Value least = 0;                     ///< inclusive, as is the next
  Value most = 0;
  std::string_view range;  ///< in words
};

/// One simple type. Exactly one of `forms`, `values`, `integer` and `longest` says what is right.
struct ValueType {
  std::string_view name;                     ///< as in the schema
  std::string_view words;                    ///< "it must be ...", of `forms` and integers
  std::string_view pattern;                  ///< of the schema, from which `forms` are, or empty
  std::span<const Form> forms;               ///< alternatives
  std::span<const std::string_view> values;  ///< of an enumeration
  bool integer = false;
  long least = 0;  ///< of an integer, inclusive
  long most = 0;
  std::size_t shortest = 0;  ///< in characters
  std::size_t longest = 0;   ///< in characters
  Scale scale;               ///< of a decimal that has a range
};

/// Those that are named outside of the table, by the names that the schema gives them.
namespace type {
extern const ValueType kAttributeName, kDecimal, kName, kNodeAddress, kSafeSide, kSetPriority,
    kSubject, kText;
}  // namespace type

/// All of them.
std::span<const ValueType* const> value_types();

/// Whether the schema accepts `value`, whose white space is collapsed.
bool is_valid(const ValueType& type, std::string_view value);

/// What is wrong with a value that is not valid, and what would be right.
std::string explain(const ValueType& type, std::string_view value);

}  // namespace mlcca::description
