// SPDX-License-Identifier: BSD-2-Clause
#include "core/verdict.hpp"

#include "mlcca/compose.hpp"
#include "mlcca/units.hpp"

namespace mlcca::core {
namespace {

/// Share of the better side that is left, in 1/1024: 0 is exactly met.
Value slack(const Comparison& c) {
  const Value larger = c.required > c.provided ? c.required : c.provided;
  if (larger == 0) return 0;
  if (larger == kUnbounded) return 1024;
  return mul_div_down(c.margin(), 1024, larger);
}

}  // namespace

const Row* deciding_row(const Verdict& verdict) {
  const Row* tightest = nullptr;
  for (const Row& row : verdict.rows) {
    const bool fits = at_run_time(row.comparison.outcome) == Outcome::fit;
    if (!verdict.granted) {
      if (!fits) return &row;
      continue;
    }
    if (row.against != Against::end_to_end) continue;
    // Sizes are met exactly as a rule; what a person wants to know is how near time and loss are.
    if (row.comparison.attribute == Attribute::max_payload) continue;
    if (tightest == nullptr || slack(row.comparison) < slack(tightest->comparison)) tightest = &row;
  }
  if (verdict.granted && tightest == nullptr && !verdict.rows.empty()) return &verdict.rows.front();
  return tightest;
}

std::optional<Value> worst_case_reaction(const Verdict& verdict) {
  const AttributeSet& required = verdict.requirement;
  const AttributeSet provided = normalised_provision(verdict.provision);
  if (!required.has(Attribute::period) || !required.has(Attribute::omission)) return std::nullopt;
  if (!provided.has(Attribute::latency)) return std::nullopt;
  const Value jitter = provided.has(Attribute::jitter) ? provided[Attribute::jitter] : 0;
  const Value silence =
      mul_saturating(add_saturating(required[Attribute::omission], 1), required[Attribute::period]);
  return add_saturating(add_saturating(silence, provided[Attribute::latency]), jitter);
}

}  // namespace mlcca::core
