// SPDX-License-Identifier: BSD-2-Clause
// The five checks: a network layer, a whole route, publisher against subscriber, everybody on a
// shared medium, capacity. All three levels call these functions.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca {

/// The answer with a line for each required attribute, in the order of the table.
struct CheckResult {
  Comparison rows[kAttributes];
  uint8_t count = 0;
  Outcome outcome = Outcome::fit;  ///< the worst of the rows; fit when nothing is required

  constexpr void add(const Comparison& row) {
    rows[count++] = row;
    outcome = worse(outcome, row.outcome);
  }
};

namespace detail {

constexpr void set_harder(AttributeSet& requirement, Attribute a, Value value) {
  if (!requirement.has(a) || satisfies(info(a).better, value, requirement[a]))
    requirement.set(a, value);
}

/// The union of two requirements that are both normalised, as it is itself then.
constexpr AttributeSet union_of_normalised(AttributeSet a, const AttributeSet& b) {
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute attribute = attribute_at(i);
    if (b.has(attribute)) set_harder(a, attribute, b[attribute]);
  }
  return a;
}

/// Rows for a requirement and a provision that are both normalised.
constexpr CheckResult check_normalised(const AttributeSet& requirement,
                                       const AttributeSet& provision) {
  CheckResult check;
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (requirement.has(a)) check.add(compare(a, requirement[a], provision));
  }
  return check;
}

/// The outcome of the same rows alone, which is less work for a compiler.
constexpr Outcome outcome_normalised(const AttributeSet& requirement,
                                     const AttributeSet& provision) {
  Outcome worst = Outcome::fit;
  for (size_t i = 0; i < kAttributes; ++i) {
    const auto a = static_cast<Attribute>(i);
    if (requirement.has(a)) worst = worse(worst, outcome_of(a, requirement[a], provision));
  }
  return worst;
}

}  // namespace detail

/// The union of two requirements: per attribute the harder value. Both are normalised first, so
/// that the explicit Deadline of one does not replace the shorter one that the other's Period
/// implies: a lenient listener never softens what a strict one asks.
constexpr AttributeSet strictest(const AttributeSet& a, const AttributeSet& b) {
  return detail::union_of_normalised(normalised_requirement(a), normalised_requirement(b));
}

/// The strictest of n requirements; the empty set for none.
constexpr AttributeSet strictest_of(const AttributeSet* all, size_t n) {
  AttributeSet result;
  for (size_t i = 0; i < n; ++i) result = strictest(result, all[i]);
  return result;
}

/// What one more subscriber of a publisher asks beside `requirement`, which is normalised. So is
/// the result.
constexpr AttributeSet with_subscriber(const AttributeSet& requirement,
                                       const AttributeSet& publisher, AttributeSet subscriber) {
  if (publisher.has(Attribute::max_payload)) subscriber.clear(Attribute::max_payload);
  return detail::union_of_normalised(requirement, normalised_requirement(subscriber));
}

/// What publisher and subscriber together ask of the networks between them, normalised. The
/// publisher's Latency, Deadline, PacketLoss and Omission are requirements of its own; its Period,
/// Bandwidth and MaxPayload are what must be carried; its Jitter is a property of the source and
/// asks nothing. The subscriber's MaxPayload says what it accepts (check_traffic()) and counts as
/// the size to be carried only when the publisher states none. A publisher whose Period is meant as
/// a rate only states a longer Deadline of its own.
constexpr AttributeSet requirement_between(AttributeSet publisher, const AttributeSet& subscriber) {
  publisher.clear(Attribute::jitter);
  return with_subscriber(normalised_requirement(publisher), publisher, subscriber);
}

/// Check 1 for a requirement that is normalised, as strictest(), requirement_between() and
/// with_subscriber() give it: who makes many checks of one requirement normalises it once.
constexpr CheckResult check_normalised_layer(const AttributeSet& requirement,
                                             const AttributeSet& provision) {
  return detail::check_normalised(requirement, normalised_provision(provision));
}

/// Check 1: a requirement against one network layer (figure 5 of the paper). A Deadline is held
/// against the provided Latency. In a requirement, MaxPayload is the size to be carried.
constexpr CheckResult check_layer(const AttributeSet& requirement, const AttributeSet& provision) {
  return check_normalised_layer(normalised_requirement(requirement), provision);
}

/// The outcome of check 1 alone.
constexpr Outcome layer_outcome(const AttributeSet& requirement, const AttributeSet& provision) {
  return detail::outcome_normalised(normalised_requirement(requirement),
                                    normalised_provision(provision));
}

namespace detail {

/// What a gateway limits only where it says so.
constexpr Attribute kMatterOfNetworks[] = {Attribute::period, Attribute::bandwidth,
                                           Attribute::max_payload};

}  // namespace detail

/// Check 1 for one hop of a route, which may take several frames for an event. A gateway is asked
/// for rate, period and size only if it limits them; the Deadline that a Period implies is asked of
/// it all the same. The requirement is normalised.
constexpr CheckResult check_normalised_hop(const AttributeSet& requirement, const Hop& hop) {
  AttributeSet asked = requirement;
  for (const Attribute a : detail::kMatterOfNetworks)
    if (hop.gateway && !hop.provision.has(a)) asked.clear(a);
  return check_normalised_layer(asked, hop.frames == 1 ? hop.provision : compose(&hop, 1));
}

/// The same for any requirement.
constexpr CheckResult check_hop(const AttributeSet& requirement, const Hop& hop) {
  return check_normalised_hop(normalised_requirement(requirement), hop);
}

/// Check 2: a requirement against the composed provision of a route. No route, or one of more than
/// kMaxComposedHops, is unfit even when nothing is required. With one hop this is check 1 for
/// events of several frames.
constexpr CheckResult check_route(const AttributeSet& requirement, const Hop* hops, size_t count,
                                  Value source_jitter = 0) {
  CheckResult check = detail::check_normalised(normalised_requirement(requirement),
                                               compose(hops, count, source_jitter));
  if (count == 0 || count > kMaxComposedHops) check.outcome = Outcome::unfit;
  return check;
}

/// Payload bytes per second that a publisher needs: its Bandwidth or one MaxPayload per Period,
/// the larger one, rounded up. False when it states neither.
constexpr bool demand_of(const AttributeSet& traffic, Value* bytes_per_second) {
  const bool periodic = traffic.has(Attribute::max_payload) && traffic.has(Attribute::period);
  if (!periodic && !traffic.has(Attribute::bandwidth)) return false;
  Value demand = traffic[Attribute::bandwidth];
  if (periodic) {
    const Value rate = mul_div_up(traffic[Attribute::max_payload], kNanosecondsPerSecond,
                                  traffic[Attribute::period]);
    demand = rate > demand ? rate : demand;
  }
  *bytes_per_second = demand;
  return true;
}

namespace detail {

/// What a subscriber may ask of the publisher itself, in the order of the table.
constexpr Attribute kTraffic[] = {Attribute::jitter, Attribute::period, Attribute::bandwidth,
                                  Attribute::max_payload};

/// What a publisher offers, with the Bandwidth that follows from its payload and period. A Period
/// of 0 says nothing about the rate.
constexpr AttributeSet offer_of(AttributeSet traffic) {
  const Value period = traffic[Attribute::period];
  if (!traffic.has(Attribute::bandwidth) && traffic.has(Attribute::max_payload) && period != 0)
    traffic.set(
        Attribute::bandwidth,
        mul_div_down(traffic[Attribute::max_payload], kNanosecondsPerSecond, period),
        traffic.is_dynamic(Attribute::period) || traffic.is_dynamic(Attribute::max_payload));
  return traffic;
}

}  // namespace detail

/// Check 3: what a publisher really offers against what a subscriber asks of it. Rows only for
/// what the subscriber states; what the publisher does not state is unknown, hence unfit, also its
/// Jitter: a strictly periodic source says Jitter 0.
///  - Period: the publisher's is not longer.
///  - Bandwidth: the publisher's, or its MaxPayload per Period rounded down, is not smaller.
///  - MaxPayload: the other way round. The subscriber's is the most that it accepts (`required`),
///    the published size (`provided`) must not be larger.
///  - Jitter: that of the source alone; the rest of the route only adds to it.
constexpr CheckResult check_traffic(const AttributeSet& traffic, const AttributeSet& subscriber) {
  const AttributeSet offer = detail::offer_of(traffic);
  CheckResult check;
  for (const Attribute a : detail::kTraffic) {
    if (!subscriber.has(a)) continue;
    Comparison row = compare(a, subscriber[a], offer);
    if (a == Attribute::max_payload && row.known)
      row.outcome = detail::outcome_of(row.provided <= row.required, row.dynamic);
    check.add(row);
  }
  return check;
}

/// Check 4: a frame on a broadcast medium reaches everybody there, so the medium is open only if
/// everybody is fulfilled. Nobody there requires nothing: fit.
constexpr CheckResult check_everybody(const AttributeSet* requirements, size_t n,
                                      const AttributeSet& provision) {
  return check_layer(strictest_of(requirements, n), provision);
}

/// The answer of check 5, in payload bytes/s.
struct CapacityCheck {
  bool known = false;  ///< the network states a Bandwidth
  Value capacity = 0;
  Value reserved = 0;
  Value demand = 0;
  Outcome outcome = Outcome::fit;

  /// What is left (fit) or missing (unfit); 0 when the capacity is not known.
  constexpr Value margin() const {
    if (!known) return 0;
    const Value load = add_saturating(reserved, demand);
    return load > capacity ? load - capacity : capacity - load;
  }
};

/// Check 5: does the demand fit beside what is reserved already? Nothing is lost by saturation,
/// and a demand without a bound never fits. A network that states no Bandwidth has no ledger: fit
/// with known == false, as a channel that requires Bandwidth is refused there by check 1 already.
constexpr CapacityCheck check_capacity(const AttributeSet& provision, Value reserved,
                                       Value demand) {
  CapacityCheck check;
  check.known = provision.has(Attribute::bandwidth);
  check.capacity = provision[Attribute::bandwidth];
  check.reserved = reserved;
  check.demand = demand;
  if (!check.known) return check;
  const bool enough =
      demand != kUnbounded && reserved <= check.capacity && demand <= check.capacity - reserved;
  check.outcome = detail::outcome_of(enough, provision.is_dynamic(Attribute::bandwidth));
  return check;
}

/// The longest time in ns from the end of a heart-beat to the reaction of a receiver that tolerates
/// `Omission` losses: (Omission + 1) * Period + Latency + Jitter. kUnbounded when the Omission, the
/// Period or a Latency is not stated. A requirement that states no Latency is bounded by its
/// Deadline; a Jitter that is not stated is at most the Latency.
constexpr Value worst_case_reaction(const AttributeSet& attributes) {
  const Attribute delay =
      attributes.has(Attribute::latency) ? Attribute::latency : Attribute::deadline;
  if (!attributes.has(Attribute::omission) || !attributes.has(Attribute::period) ||
      !attributes.has(delay))
    return kUnbounded;
  const Value jitter = attributes[attributes.has(Attribute::jitter) ? Attribute::jitter : delay];
  const Value silence = mul_saturating(add_saturating(attributes[Attribute::omission], 1),
                                       attributes[Attribute::period]);
  return add_saturating(add_saturating(silence, attributes[delay]), jitter);
}

}  // namespace mlcca
