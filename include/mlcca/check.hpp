// SPDX-License-Identifier: BSD-2-Clause
// The five checks: one network layer, a complete route, publisher against subscriber, all
// subscribers of a shared medium, and capacity. Design time, compile time and run time all call
// these functions. C++14, freestanding.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca {

/// The result of a check, with a row for each required attribute in the order of the table.
struct CheckResult {
  Comparison rows[kAttributes];
  uint8_t count = 0;
  Outcome outcome = Outcome::fit;  ///< the worst outcome of all rows; fit if nothing is required

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

/// The union of two normalised requirements; the result is normalised too.
constexpr AttributeSet union_of_normalised(AttributeSet a, const AttributeSet& b) {
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute attribute = attribute_at(i);
    if (b.has(attribute)) set_harder(a, attribute, b[attribute]);
  }
  return a;
}

/// Compares a normalised requirement with a normalised provision.
constexpr CheckResult check_normalised(const AttributeSet& requirement,
                                       const AttributeSet& provision) {
  CheckResult check;
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (requirement.has(a)) check.add(compare(a, requirement[a], provision));
  }
  return check;
}

/// Only the outcome of check_normalised(), which is less work for the compiler.
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

/// The strictest union of two requirements: for each attribute the harder value. Both are
/// normalised first, so that an explicit Deadline of one does not replace a shorter one that the
/// other's Period implies: a lenient subscriber never weakens the requirement of a strict one.
constexpr AttributeSet strictest(const AttributeSet& a, const AttributeSet& b) {
  return detail::union_of_normalised(normalised_requirement(a), normalised_requirement(b));
}

/// The strictest union of n requirements; the empty set if n is 0.
constexpr AttributeSet strictest_of(const AttributeSet* all, size_t n) {
  AttributeSet result;
  for (size_t i = 0; i < n; ++i) result = strictest(result, all[i]);
  return result;
}

/// Adds the requirement of a further subscriber to `requirement`, the normalised one of a publisher
/// and its other subscribers. The result is normalised.
constexpr AttributeSet with_subscriber(const AttributeSet& requirement,
                                       const AttributeSet& publisher, AttributeSet subscriber) {
  if (publisher.has(Attribute::max_payload)) subscriber.clear(Attribute::max_payload);
  return detail::union_of_normalised(requirement, normalised_requirement(subscriber));
}

/// The normalised requirement of a publisher and a subscriber towards the networks between them. Of
/// the publisher, Latency, Deadline, PacketLoss and Omission are requirements; Period, Bandwidth
/// and MaxPayload must be carried; Jitter is a property of the source and requires nothing. The
/// subscriber's MaxPayload is what it accepts (check_traffic()) and only counts as the size to be
/// carried if the publisher states none. A publisher whose Period is only a rate states a longer
/// Deadline.
constexpr AttributeSet requirement_between(AttributeSet publisher, const AttributeSet& subscriber) {
  publisher.clear(Attribute::jitter);
  return with_subscriber(normalised_requirement(publisher), publisher, subscriber);
}

/// Check 1 for a normalised requirement, as strictest(), requirement_between() and
/// with_subscriber() return it. It saves normalising a requirement that is checked many times.
constexpr CheckResult check_normalised_layer(const AttributeSet& requirement,
                                             const AttributeSet& provision) {
  return detail::check_normalised(requirement, normalised_provision(provision));
}

/// Check 1: a requirement against one network layer (figure 5 of the paper). A Deadline is compared
/// with the provided Latency. MaxPayload in a requirement is the size to be carried.
constexpr CheckResult check_layer(const AttributeSet& requirement, const AttributeSet& provision) {
  return check_normalised_layer(normalised_requirement(requirement), provision);
}

/// Only the outcome of check 1.
constexpr Outcome layer_outcome(const AttributeSet& requirement, const AttributeSet& provision) {
  return detail::outcome_normalised(normalised_requirement(requirement),
                                    normalised_provision(provision));
}

namespace detail {

/// The attributes that a gateway limits only if it states them.
constexpr Attribute kMatterOfNetworks[] = {Attribute::period, Attribute::bandwidth,
                                           Attribute::max_payload};

}  // namespace detail

/// Check 1 for one hop of a route, which may carry an event in several frames. The requirement is
/// normalised. A gateway is asked for Period, Bandwidth and MaxPayload only if it states them; the
/// Deadline that a Period implies is compared in any case.
constexpr CheckResult check_normalised_hop(const AttributeSet& requirement, const Hop& hop) {
  AttributeSet asked = requirement;
  for (const Attribute a : detail::kMatterOfNetworks)
    if (hop.gateway && !hop.provision.has(a)) asked.clear(a);
  return check_normalised_layer(asked, hop.frames == 1 ? hop.provision : compose(&hop, 1));
}

/// Check 1 for one hop and a requirement that need not be normalised.
constexpr CheckResult check_hop(const AttributeSet& requirement, const Hop& hop) {
  return check_normalised_hop(normalised_requirement(requirement), hop);
}

/// Check 2: a requirement against the composed provision of a route. A route without hops, or with
/// more than kMaxComposedHops, is unfit even if nothing is required. With one hop it is check 1 for
/// events of several frames. `source_jitter`: the publisher's Jitter in ns.
constexpr CheckResult check_route(const AttributeSet& requirement, const Hop* hops, size_t count,
                                  Value source_jitter = 0) {
  CheckResult check = detail::check_normalised(normalised_requirement(requirement),
                                               compose(hops, count, source_jitter));
  if (count == 0 || count > kMaxComposedHops) check.outcome = Outcome::unfit;
  return check;
}

/// Computes the payload bytes per second of a traffic specification: its Bandwidth or one
/// MaxPayload per Period, the larger of the two, rounded up. Returns false, and leaves
/// *bytes_per_second unchanged, if it states neither.
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

/// What a subscriber may require of the publisher itself, in the order of the table.
constexpr Attribute kTraffic[] = {Attribute::jitter, Attribute::period, Attribute::bandwidth,
                                  Attribute::max_payload};

/// The traffic of a publisher with the Bandwidth that follows from payload and Period. A Period of
/// 0 states no rate.
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

/// Check 3: what a publisher sends against what a subscriber requires of it. There are rows only
/// for what the subscriber states. What the publisher does not state is unknown and so unfit, also
/// its Jitter: a strictly periodic source states Jitter 0.
///  - Period: the publisher's is not longer.
///  - Bandwidth: the publisher's, or its MaxPayload per Period rounded down, is not smaller.
///  - MaxPayload: reversed. The subscriber states the most that it accepts (`required`), and the
///    published size (`provided`) must not be larger.
///  - Jitter: that of the source alone; the route only adds to it.
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

/// Check 4: a frame on a broadcast medium reaches all subscribers there, so the medium may be used
/// only if all of them are fulfilled. Without subscribers it is fit.
constexpr CheckResult check_subscribers(const AttributeSet* requirements, size_t n,
                                        const AttributeSet& provision) {
  return check_layer(strictest_of(requirements, n), provision);
}

/// The result of check 5; rates are in payload bytes/s.
struct CapacityCheck {
  bool known = false;  ///< the network states a Bandwidth
  Value capacity = 0;
  Value reserved = 0;
  Value demand = 0;
  Outcome outcome = Outcome::fit;

  /// What is left (if fit) or missing (if unfit); 0 if the capacity is unknown.
  constexpr Value margin() const {
    if (!known) return 0;
    const Value load = add_saturating(reserved, demand);
    return load > capacity ? load - capacity : capacity - load;
  }
};

/// Check 5: whether a demand fits beside what is reserved already. A demand without a bound never
/// fits. A network that states no Bandwidth has no ledger: the result is fit with known == false,
/// since check 1 already refuses a channel there that requires Bandwidth.
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

/// The worst-case reaction: the longest time in ns from the last heart-beat until a receiver that
/// tolerates `Omission` losses reacts, (Omission + 1) * Period + Latency + Jitter.
/// kUnbounded if Omission, Period or a delay is not stated. Without a Latency the Deadline is used;
/// a Jitter that is not stated is taken as that delay.
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
