// SPDX-License-Identifier: BSD-2-Clause
// The provision of a whole route from the provisions of its hops, rounded once to the safe side:
// never better than exact arithmetic, and the same for every order of the hops.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/exact.hpp"

namespace mlcca {

/// One network or gateway of a route.
struct Hop {
  AttributeSet provision;
  uint16_t medium = 0;  ///< hops with the same number share one medium's time
  uint16_t frames = 1;  ///< frames of one event on this hop; 0: not known, assume the worst
};

/// A required Period without a Deadline asks for Deadline = Period. Dynamic marks mean nothing in
/// a requirement and are cleared.
constexpr AttributeSet normalised_requirement(AttributeSet requirement) {
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (requirement.has(a)) requirement.set(a, requirement[a]);
  }
  if (requirement.has(Attribute::period) && !requirement.has(Attribute::deadline))
    requirement.set(Attribute::deadline, requirement[Attribute::period]);
  return requirement;
}

namespace detail {

/// The attribute whose value a provision gives for `a`: a Period without a Latency promises
/// Latency = Period.
constexpr Attribute stated_by(const AttributeSet& provision, Attribute a) {
  return a == Attribute::latency && !provision.has(a) ? Attribute::period : a;
}

}  // namespace detail

/// A provided Period without a Latency promises Latency = Period. A Deadline is nobody's to
/// provide, and no loss is more than certain.
constexpr AttributeSet normalised_provision(AttributeSet provision) {
  const Attribute latency = detail::stated_by(provision, Attribute::latency);
  if (provision.has(latency))
    provision.set(Attribute::latency, provision[latency], provision.is_dynamic(latency));
  if (provision[Attribute::packet_loss] > kCertainLoss)
    provision.set(Attribute::packet_loss, kCertainLoss,
                  provision.is_dynamic(Attribute::packet_loss));
  return provision.clear(Attribute::deadline);
}

namespace detail {

/// The hops of a route, each of which states the attribute that is being composed.
struct Hops {
  const Hop* hop;
  size_t count;

  constexpr Value value(size_t i, Attribute a) const {
    return hop[i].provision[stated_by(hop[i].provision, a)];
  }
};

constexpr Value sum(const Hops& hops, Attribute a) {
  Value total = 0;
  for (size_t i = 0; i < hops.count; ++i) total = add_saturating(total, hops.value(i, a));
  return total;
}

constexpr Value largest(const Hops& hops, Attribute a) {
  Value most = 0;
  for (size_t i = 0; i < hops.count; ++i) {
    const Value v = hops.value(i, a);
    most = v > most ? v : most;
  }
  return most;
}

constexpr Value smallest(const Hops& hops, Attribute a) {
  Value least = kUnbounded;
  for (size_t i = 0; i < hops.count; ++i) {
    const Value v = hops.value(i, a);
    least = v < least ? v : least;
  }
  return least;
}

constexpr bool is_first_on_medium(const Hops& hops, size_t index) {
  for (size_t i = 0; i < index; ++i)
    if (hops.hop[i].medium == hops.hop[index].medium) return false;
  return true;
}

/// Every link of a medium takes its share of the medium's time: equation 1 of the paper.
constexpr Value medium_rate(const Hops& hops, Attribute a, uint16_t medium) {
  ReciprocalSum sum;
  for (size_t i = 0; i < hops.count; ++i)
    if (hops.hop[i].medium == medium) sum.add(hops.value(i, a));
  return sum.value();
}

constexpr Value shared_medium(const Hops& hops, Attribute a) {
  Value least = kUnbounded;
  for (size_t i = 0; i < hops.count; ++i) {
    if (!is_first_on_medium(hops, i)) continue;
    const Value rate = medium_rate(hops, a, hops.hop[i].medium);
    least = rate < least ? rate : least;
  }
  return least;
}

constexpr Value loss(const Hops& hops, Attribute a) {
  Survival survival;
  for (size_t i = 0; i < hops.count; ++i) survival.add(hops.value(i, a), hops.hop[i].frames);
  return survival.loss();
}

/// A run of `a` lost events on one hop can meet a run of `b` on the next after each event that
/// got through: (a + 1)(b + 1) - 1. A bound on lost frames bounds no events of several frames.
constexpr Value consecutive(const Hops& hops, Attribute a) {
  Value run = 0;
  for (size_t i = 0; i < hops.count; ++i) {
    const Value degree = hops.value(i, a);
    if (degree != 0 && hops.hop[i].frames != 1) return kUnbounded;
    run = add_saturating(add_saturating(mul_saturating(run, degree), run), degree);
  }
  return run;
}

constexpr Value composed_value(const Hops& hops, Attribute a) {
  switch (info(a).composition) {
    case Composition::sum:
      return sum(hops, a);
    case Composition::slowest:
      return largest(hops, a);
    case Composition::shared_medium:
      return shared_medium(hops, a);
    case Composition::survival:
      return loss(hops, a);
    case Composition::consecutive:
      return consecutive(hops, a);
    case Composition::smallest:
      return smallest(hops, a);
    case Composition::not_provided:
      break;
  }
  return 0;
}

/// Sets one attribute of a route, unless a hop does not state it.
constexpr void compose_attribute(const Hops& hops, Attribute a, Value source_jitter,
                                 AttributeSet& result) {
  bool dynamic = false;
  for (size_t i = 0; i < hops.count; ++i) {
    const AttributeSet& provision = hops.hop[i].provision;
    const Attribute stated = stated_by(provision, a);
    if (!provision.has(stated)) return;
    dynamic = dynamic || provision.is_dynamic(stated);
  }
  Value value = composed_value(hops, a);
  if (a == Attribute::jitter) value = add_saturating(value, source_jitter);
  result.set(a, value, dynamic);
}

}  // namespace detail

/// What a route gives. An attribute that a hop does not state is not stated by the route; one that
/// is a best case (dynamic) on a hop is a best case of the route. No hops, or more than
/// kMaxComposedHops, give the empty set: nothing is provided, hence every requirement refused.
/// source_jitter is the publisher's own, in ns.
constexpr AttributeSet compose(const Hop* hops, size_t count, Value source_jitter = 0) {
  AttributeSet result;
  if (count == 0 || count > kMaxComposedHops) return result;
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (info(a).composition != Composition::not_provided)
      detail::compose_attribute(detail::Hops{hops, count}, a, source_jitter, result);
  }
  return result;
}

}  // namespace mlcca
