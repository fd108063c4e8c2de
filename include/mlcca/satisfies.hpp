// SPDX-License-Identifier: BSD-2-Clause
// Compares one required attribute with what is provided: fit, unfit, or decided at run time. C++14,
// freestanding.
#pragma once
#include "mlcca/attribute.hpp"

namespace mlcca {

/// The outcome of a comparison. `run_time`: only a best case is provided and does not refute it, so
/// each request is decided at run time.
enum class Outcome : uint8_t { fit, unfit, run_time };

/// The worse of two outcomes: unfit is worse than run_time, and run_time worse than fit.
constexpr Outcome worse(Outcome a, Outcome b) {
  if (a == Outcome::unfit || b == Outcome::unfit) return Outcome::unfit;
  return a == Outcome::fit ? b : a;
}

/// The outcome at run time, where a best case that no measured value replaced counts as unknown and
/// is refused.
constexpr Outcome at_run_time(Outcome outcome) {
  return outcome == Outcome::fit ? Outcome::fit : Outcome::unfit;
}

/// One row of a result: what is required, what is provided, and the outcome.
struct Comparison {
  Attribute attribute = Attribute::latency;  ///< the required attribute
  Outcome outcome = Outcome::unfit;
  bool known = false;    ///< whether it is provided at all
  bool dynamic = false;  ///< whether it is provided as a best case only
  Value required = 0;
  Value provided = 0;  ///< 0 if it is not provided

  /// The distance between the two values; 0 if nothing is provided.
  constexpr Value margin() const {
    if (!known) return 0;
    return required > provided ? required - provided : provided - required;
  }
};

/// The provided attribute with which a required one is compared: the Latency for a Deadline,
/// otherwise the same attribute.
constexpr Attribute held_against(Attribute required) {
  return required == Attribute::deadline ? Attribute::latency : required;
}

/// Whether a provided value is at least as good as the required one.
constexpr bool satisfies(Better better, Value provided, Value required) {
  return better == Better::smaller ? provided <= required : provided >= required;
}

namespace detail {

/// A best case can refute, but never grant.
constexpr Outcome outcome_of(bool satisfied, bool dynamic) {
  if (!satisfied) return Outcome::unfit;
  return dynamic ? Outcome::run_time : Outcome::fit;
}

}  // namespace detail

/// The outcome for one required value. The provision is taken as it is; see normalised_provision()
/// for what follows from a stated Period. What is not provided fulfils nothing.
constexpr Outcome outcome_of(Attribute attribute, Value required, const AttributeSet& provision) {
  const Attribute source = held_against(attribute);
  if (!provision.has(source)) return Outcome::unfit;
  const Better better = kAttributeTable[static_cast<size_t>(attribute)].better;
  return detail::outcome_of(satisfies(better, provision[source], required),
                            provision.is_dynamic(source));
}

/// The same comparison with its values, for display.
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
