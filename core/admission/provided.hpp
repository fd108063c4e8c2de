// SPDX-License-Identifier: BSD-2-Clause
// What a hop gives by what is computed of it, beside what is stated.
#pragma once
#include <cstddef>

#include "core/model/system.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::core {

inline bool is_missing(const AttributeSet& provision, Attribute a) {
  return !provision.has(a) || provision.is_dynamic(a);
}

inline void provide(AttributeSet& provision, Attribute a, Value value, bool dynamic = false) {
  if (is_missing(provision, a)) provision.set(a, value, dynamic);
}

/// What is computed sustains the Period of the events. That promises nothing of how long they take,
/// as a Period that the description states does: without a Latency there is none.
inline void provide_period(AttributeSet& provision, Value period, bool dynamic = false) {
  if (!is_missing(provision, Attribute::period)) return;
  if (!provision.has(Attribute::latency)) provision.set(Attribute::latency, kUnbounded);
  provision.set(Attribute::period, period, dynamic);
}

inline void provide_response(AttributeSet& provision, Value response) {
  provide(provision, Attribute::latency, response);
  provide(provision, Attribute::jitter, response);
}

/// Over a mesh events are sent in packets, however long they are, and as often as the time of the
/// medium lasts.
inline void provide_events(AttributeSet& provision, const AttributeSet& offered,
                           bool dynamic = false) {
  provide(provision, Attribute::max_payload, kUnbounded, dynamic);
  if (offered.has(Attribute::period))
    provide_period(provision, offered[Attribute::period], dynamic);
}

/// What the links of a way give, beside their rate, which is reckoned as medium time. Where the
/// mesh itself is said to give something else for good, the worse of both counts.
inline void provide_links(AttributeSet& provision, const AttributeSet& given, bool dynamic) {
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (a == Attribute::bandwidth || !given.has(a)) continue;
    Value value = given[a];
    if (!is_missing(provision, a) && satisfies(info(a).better, value, provision[a]))
      value = provision[a];
    provision.set(a, value, dynamic);
  }
}

/// From a node to itself: there is nothing in between.
inline void provide_everything(AttributeSet& provision, const AttributeSet& offered) {
  for (const Attribute a :
       {Attribute::latency, Attribute::jitter, Attribute::omission, Attribute::packet_loss})
    provide(provision, a, 0);
  provide(provision, Attribute::bandwidth, kUnbounded);
  provide_events(provision, offered);
}

}  // namespace mlcca::core
