// SPDX-License-Identifier: BSD-2-Clause
// One attribute that is asked for against what is provided: fit, unfit, or decided at run time.
// C++14, freestanding.
#pragma once
#include "mlcca/attribute.hpp"

namespace mlcca {

/// `run_time`: a best case does not refute it, so the network decides each request at run time.
enum class Outcome : uint8_t { fit, unfit, run_time };

/// The worse of two: unfit before run_time before fit.
constexpr Outcome worse(Outcome a, Outcome b) {
  if (a == Outcome::unfit || b == Outcome::unfit) return Outcome::unfit;
  return a == Outcome::fit ? b : a;
}

/// At run time a best case that nothing replaced is unknown, hence refused.
constexpr Outcome at_run_time(Outcome outcome) {
  return outcome == Outcome::fit ? Outcome::fit : Outcome::unfit;
}

/// One line of an answer: what is required, what is provided, and what follows.
struct Comparison {
  Attribute attribute = Attribute::latency;  ///< as it is required
  Outcome outcome = Outcome::unfit;
  bool known = false;    ///< provided at all
  bool dynamic = false;  ///< provided as a best case only
  Value required = 0;
  Value provided = 0;  ///< 0 when not known

  /// How far apart the two are, whichever is larger; 0 when nothing is provided.
  constexpr Value margin() const {
    if (!known) return 0;
    return required > provided ? required - provided : provided - required;
  }
};

/// The provided attribute that a required one is held against: a Deadline against the Latency,
/// every other one against itself.
constexpr Attribute held_against(Attribute required) {
  return required == Attribute::deadline ? Attribute::latency : required;
}

constexpr bool satisfies(Better better, Value provided, Value required) {
  return better == Better::smaller ? provided <= required : provided >= required;
}

namespace detail {

/// A best case can refute, never grant.
constexpr Outcome outcome_of(bool satisfied, bool dynamic) {
  if (!satisfied) return Outcome::unfit;
  return dynamic ? Outcome::run_time : Outcome::fit;
}

}  // namespace detail

/// One required value against a provision, which is taken as it is: see normalised_provision() for
/// what follows from a stated Period. What is not provided does not fulfil anything.
constexpr Outcome outcome_of(Attribute attribute, Value required, const AttributeSet& provision) {
  const Attribute source = held_against(attribute);
  if (!provision.has(source)) return Outcome::unfit;
  const Better better = kAttributeTable[static_cast<size_t>(attribute)].better;
  return detail::outcome_of(satisfies(better, provision[source], required),
                            provision.is_dynamic(source));
}

/// The same with the values, to be shown.
constexpr Comparison compare(Attribute attribute, Value required, const AttributeSet& provision) {
  const Attribute source = held_against(attribute);
  Comparison row;
  row.attribute = attribute;
  row.outcome = outcome_of(attribute, required, provision);
  row.known = provision.has(source);
  row.dynamic = row.known && provision.is_dynamic(source);
  row.required = required;
  row.provided = row.known ? provision[source] : 0;
  return row;
}

}  // namespace mlcca
