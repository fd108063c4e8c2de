// SPDX-License-Identifier: BSD-2-Clause
// Completes the stated provision of a hop by computed values. A computed value replaces a best case
// and fills what is not stated, but never a stated value (except for provide_links()).
#pragma once
#include <cstddef>

#include "core/model/system.hpp"
#include "mlcca/attribute.hpp"
#include "mlcca/satisfies.hpp"

namespace mlcca::core {

/// Whether no guaranteed value is stated.
inline bool is_missing(const AttributeSet& provision, Attribute a) {
  return !provision.has(a) || provision.is_dynamic(a);
}

inline void provide(AttributeSet& provision, Attribute a, Value value, bool dynamic = false) {
  if (is_missing(provision, a)) provision.set(a, value, dynamic);
}

/// Provides the Period of the events, because the medium sustains their rate. Unlike a stated
/// Period it implies no Latency, so an unbounded Latency is set where none is stated.
inline void provide_period(AttributeSet& provision, Value period, bool dynamic = false) {
  if (!is_missing(provision, Attribute::period)) return;
  if (!provision.has(Attribute::latency)) provision.set(Attribute::latency, kUnbounded);
  provision.set(Attribute::period, period, dynamic);
}

/// Provides the response time (ns) of a bus as Latency and as Jitter.
inline void provide_response(AttributeSet& provision, Value response) {
  provide(provision, Attribute::latency, response);
  provide(provision, Attribute::jitter, response);
}

/// A mesh fragments events of any length, and sustains them while medium time is reserved.
inline void provide_events(AttributeSet& provision, const AttributeSet& offered,
                           bool dynamic = false) {
  provide(provision, Attribute::max_payload, kUnbounded, dynamic);
  if (offered.has(Attribute::period))
    provide_period(provision, offered[Attribute::period], dynamic);
}

/// Provides what the links of a path give, except for their rate, which counts as medium time.
/// Where the mesh also states a guaranteed value, the worse of the two counts.
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

/// Provides everything for a delivery from a mesh node to itself, which sends nothing.
inline void provide_everything(AttributeSet& provision, const AttributeSet& offered) {
  for (const Attribute a :
       {Attribute::latency, Attribute::jitter, Attribute::omission, Attribute::packet_loss})
    provide(provision, a, 0);
  provide(provision, Attribute::bandwidth, kUnbounded);
  provide_events(provision, offered);
}

}  // namespace mlcca::core
