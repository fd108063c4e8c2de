// SPDX-License-Identifier: BSD-2-Clause
// The traffic that an entry admits, and how its events are supervised.
#include <algorithm>

#include "core/gates/plan.hpp"
#include "core/gates/together.hpp"
#include "core/model/verdict.hpp"
#include "mlcca/arithmetic.hpp"
#include "mlcca/check.hpp"

namespace mlcca::core {
namespace {

/// Divisor for 500 ppm, which allow for the difference between the clocks of publisher and gateway.
constexpr Value kClocks = 2000;

Value slower(Value time) { return add_saturating(time, time / kClocks); }

/// The denominator of per_byte.
constexpr Value kUnit = 256;

/// Converts policing by frames to policing by bytes, with the bytes of its longest frames.
Policing by_bytes(const Policing& p, Value longest) {
  if (p.per_frame == 0) return p;
  longest = std::max<Value>(longest, 1);
  return {0, std::max<Value>(mul_saturating(p.per_frame, kUnit) / longest, 1), p.tolerance,
          p.counts_only};
}

}  // namespace

Policing together(Policing a, Policing b, Value longest) {
  if (!a.any() || !b.any()) return {};
  if ((a.per_frame == 0) != (b.per_frame == 0)) {
    a = by_bytes(a, longest);
    b = by_bytes(b, longest);
  }
  const bool by_frame = a.per_frame != 0;
  const Value x = by_frame ? a.per_frame : a.per_byte;
  const Value y = by_frame ? b.per_frame : b.per_byte;
  const Value sum = std::max<Value>(mul_div_down(x, y, add_saturating(x, y)), 1);
  // Entry a may send 1 + a.tolerance / x frames at once (or bytes of both).
  const Value early =
      add_saturating(mul_div_up(a.tolerance, sum, x), mul_div_up(b.tolerance, sum, y));
  const Value one = by_frame ? sum : mul_saturating(sum, longest) / kUnit;
  return {by_frame ? sum : 0, by_frame ? 0 : sum, add_saturating(early, one),
          a.counts_only || b.counts_only};
}

Watching together(const Watching& a, const Watching& b) {
  return {std::max(a.period, b.period), std::max(a.silence, b.silence),
          std::max(a.together, b.together)};
}

Policing policing_of(const AttributeSet& offered, std::uint64_t frames, Value largest) {
  constexpr Value second = 1'000'000'000;
  const auto shortened = [](Value time) { return time - time / kClocks; };
  const Value jitter = offered[Attribute::jitter];
  Policing out;
  if (offered.has(Attribute::period)) {
    const Value period = shortened(offered[Attribute::period]);
    out.per_frame = std::max<Value>(period / std::max<Value>(frames, 1), 1);
    // The frames of an event come together, and the next event may be early.
    out.tolerance = add_saturating(mul_saturating(period, 2) - out.per_frame, jitter);
  } else if (offered.has(Attribute::bandwidth) && offered[Attribute::bandwidth] != 0) {
    out.per_byte =
        std::max<Value>(shortened(mul_div_down(second, kUnit, offered[Attribute::bandwidth])), 1);
    const Value event =
        offered.has(Attribute::max_payload) ? offered[Attribute::max_payload] : largest;
    out.tolerance = add_saturating(
        mul_saturating(out.per_byte, mul_saturating(std::max<Value>(event, 1), 2)) / kUnit, jitter);
  }
  return out;
}

namespace {

Value silence_by(AttributeSet terms) {
  terms.set(Attribute::period, slower(terms[Attribute::period]));
  terms.set(Attribute::latency, 0);
  const Value silence = mlcca::worst_case_reaction(terms);
  return silence == kUnbounded ? 0 : silence;
}

}  // namespace

Value silence_of(const Verdict& v) {
  return v.granted && worst_case_reaction(v) ? silence_by(reaction_terms(v)) : 0;
}

Value silence_here(const Verdict& v) {
  AttributeSet terms = reaction_terms(v);
  if (!v.granted || v.sporadic || !terms.has(Attribute::omission) || !terms.has(Attribute::period))
    return 0;
  if (!terms.has(Attribute::jitter)) terms.set(Attribute::jitter, 0);
  return silence_by(terms);
}

}  // namespace mlcca::core
