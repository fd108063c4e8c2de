// SPDX-License-Identifier: BSD-2-Clause
// Composition: the provision of a route from the provisions of its hops. It is rounded once to the
// safe side, so it is never better than exact arithmetic and does not depend on the order of the
// hops. C++14, freestanding.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/exact.hpp"

namespace mlcca {

/// One network or gateway of a route.
struct Hop {
  AttributeSet provision;
  uint16_t medium = 0;  ///< hops with equal numbers share the time of one medium
  uint16_t frames = 1;  ///< frames of one event on this hop; 0: unknown, the worst is assumed
  bool gateway =
      false;  ///< forwards between media: it limits rate, period and size only if it states them
};

/// The value of one attribute on a hop, for compose_values().
struct HopValue {
  Value value = 0;
  uint16_t medium = 0;
  uint16_t frames = 1;
};

/// Adds the Deadline that a required Period without a Deadline implies, and removes dynamic marks,
/// which have no meaning in a requirement.
constexpr AttributeSet normalised_requirement(AttributeSet requirement) {
  requirement.clear_dynamic();
  if (requirement.has(Attribute::period) && !requirement.has(Attribute::deadline))
    requirement.set(Attribute::deadline, requirement[Attribute::period]);
  return requirement;
}

namespace detail {

/// The attribute whose value a provision uses for `a`: a Period without a Latency promises a
/// Latency of the same length.
constexpr Attribute stated_by(const AttributeSet& provision, Attribute a) {
  return a == Attribute::latency && !provision.has(a) ? Attribute::period : a;
}

}  // namespace detail

/// Adds the Latency that a provided Period without a Latency promises, limits PacketLoss to 1, and
/// removes a Deadline, which nobody provides.
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

/// The values of one attribute on all hops of a route.
struct HopValues {
  const HopValue* hop;
  size_t count;
};

constexpr Value sum(const HopValues& hops) {
  Value total = 0;
  for (size_t i = 0; i < hops.count; ++i) total = add_saturating(total, hops.hop[i].value);
  return total;
}

constexpr Value largest(const HopValues& hops) {
  Value most = 0;
  for (size_t i = 0; i < hops.count; ++i)
    most = hops.hop[i].value > most ? hops.hop[i].value : most;
  return most;
}

constexpr Value smallest(const HopValues& hops) {
  Value least = kUnbounded;
  for (size_t i = 0; i < hops.count; ++i)
    least = hops.hop[i].value < least ? hops.hop[i].value : least;
  return least;
}

constexpr bool is_first_on_medium(const HopValues& hops, size_t index) {
  for (size_t i = 0; i < index; ++i)
    if (hops.hop[i].medium == hops.hop[index].medium) return false;
  return true;
}

/// The links of one medium share its time: equation 1 of the paper, 1/R = sum of 1/R_i.
constexpr Value medium_rate(const HopValues& hops, uint16_t medium) {
  ReciprocalSum sum;
  for (size_t i = 0; i < hops.count; ++i)
    if (hops.hop[i].medium == medium) sum.add(hops.hop[i].value);
  return sum.value();
}

constexpr Value shared_medium(const HopValues& hops) {
  Value least = kUnbounded;
  for (size_t i = 0; i < hops.count; ++i) {
    if (!is_first_on_medium(hops, i)) continue;
    const Value rate = medium_rate(hops, hops.hop[i].medium);
    least = rate < least ? rate : least;
  }
  return least;
}

constexpr Value loss(const HopValues& hops) {
  Survival survival;
  for (size_t i = 0; i < hops.count; ++i) survival.add(hops.hop[i].value, hops.hop[i].frames);
  return survival.loss();
}

/// After each event that got through a run of `a` lost events on one hop, a run of `b` on the next
/// one may follow: (a + 1)(b + 1) - 1. A bound on lost frames bounds no events of several frames.
constexpr Value consecutive(const HopValues& hops) {
  Value run = 0;
  for (size_t i = 0; i < hops.count; ++i) {
    const Value degree = hops.hop[i].value;
    if (degree != 0 && hops.hop[i].frames != 1) return kUnbounded;
    run = add_saturating(add_saturating(mul_saturating(run, degree), run), degree);
  }
  return run;
}

}  // namespace detail

/// Composes the values of one attribute, built-in or user-defined, of at most kMaxComposedHops
/// hops. Composition survival takes shares of 1e-9; not_provided returns 0.
constexpr Value compose_values(Composition composition, const HopValue* values, size_t count) {
  const detail::HopValues hops = {values, count};
  switch (composition) {
    case Composition::sum:
      return detail::sum(hops);
    case Composition::slowest:
      return detail::largest(hops);
    case Composition::shared_medium:
      return detail::shared_medium(hops);
    case Composition::survival:
      return detail::loss(hops);
    case Composition::consecutive:
      return detail::consecutive(hops);
    case Composition::smallest:
      return detail::smallest(hops);
    case Composition::not_provided:
      break;
  }
  return 0;
}

/// Sets *value to what a gateway provides of a user-defined attribute that it does not state: it
/// does not limit a maximum or minimum. Returns false and leaves *value unchanged for other
/// compositions, which a gateway has to state.
constexpr bool unlimited_by_gateway(Composition composition, Value* value) {
  if (composition != Composition::slowest && composition != Composition::smallest) return false;
  *value = composition == Composition::slowest ? 0 : kUnbounded;
  return true;
}

namespace detail {

struct Stated {
  bool known = false;
  bool dynamic = false;
  Value value = 0;
};

/// What a gateway provides if it states nothing. It is no medium: rate, period and size are not
/// limited, but its delay is unbounded unless it states a Latency or a Period.
constexpr Stated unstated_by_gateway(Attribute a) {
  switch (a) {
    case Attribute::bandwidth:
    case Attribute::max_payload:
    case Attribute::latency:
      return {true, false, kUnbounded};
    case Attribute::period:
      return {true, false, 0};
    default:
      return {};
  }
}

constexpr Stated stated_on(const Hop& hop, Attribute a) {
  const Attribute source = stated_by(hop.provision, a);
  if (hop.provision.has(source))
    return {true, hop.provision.is_dynamic(source), hop.provision[source]};
  return hop.gateway ? unstated_by_gateway(a) : Stated{};
}

/// Sets one attribute of a route, unless some hop does not provide it.
constexpr void compose_attribute(const Hop* hops, size_t count, Attribute a, Value source_jitter,
                                 AttributeSet& result) {
  HopValue values[kMaxComposedHops];
  bool dynamic = false;
  for (size_t i = 0; i < count; ++i) {
    const Stated stated = stated_on(hops[i], a);
    if (!stated.known) return;
    dynamic = dynamic || stated.dynamic;
    values[i].value = stated.value;
    values[i].medium = hops[i].medium;
    values[i].frames = hops[i].frames;
  }
  Value value = compose_values(info(a).composition, values, count);
  if (a == Attribute::jitter) value = add_saturating(value, source_jitter);
  result.set(a, value, dynamic);
}

}  // namespace detail

/// The provision of a route. An attribute that some hop does not provide is not provided; one that
/// is a best case (dynamic) on some hop is a best case of the route. Without hops, or with more
/// than kMaxComposedHops, the result is the empty set, so that every requirement is refused.
/// `source_jitter`: the publisher's Jitter in ns.
constexpr AttributeSet compose(const Hop* hops, size_t count, Value source_jitter = 0) {
  AttributeSet result;
  if (count == 0 || count > kMaxComposedHops) return result;
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (info(a).composition != Composition::not_provided)
      detail::compose_attribute(hops, count, a, source_jitter, result);
  }
  return result;
}

}  // namespace mlcca
