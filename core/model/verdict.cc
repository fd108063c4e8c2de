// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/verdict.hpp"

#include <algorithm>

#include "mlcca/check.hpp"
#include "mlcca/units.hpp"

namespace mlcca::core {
namespace {

/// Whether the row says nothing about the quality of a grant: as a rule exactly the offered payload
/// and rate are carried. A person wants to know the margins of time and loss.
bool is_met_by_rule(const Comparison& c) {
  return c.attribute == Attribute::max_payload ||
         (c.attribute == Attribute::period && c.provided == c.required);
}

/// Whether the row states the bandwidth of a path alone, while another row states the free medium
/// time, which is less.
bool is_said_of_the_medium(const Verdict& verdict, const Row& row) {
  return !row.is_user() && row.comparison.attribute == Attribute::bandwidth &&
         std::ranges::any_of(
             verdict.rows, [](const Row& other) { return other.against == Against::medium_time; });
}

/// The row that refuses: the first that is unfit, otherwise the first that is unknown.
const Row* refusing_row(const Verdict& verdict) {
  const Row* unknown = nullptr;
  for (const Row& row : verdict.rows) {
    const bool fits = at_run_time(row.comparison.outcome) == Outcome::fit;
    if (fits || is_said_by_another(verdict, row)) continue;
    if (is_unfit(row)) return &row;
    if (unknown == nullptr) unknown = &row;
  }
  return unknown;
}

}  // namespace

Value slack(const Comparison& c) {
  const Value larger = c.required > c.provided ? c.required : c.provided;
  if (larger == 0) return 0;
  if (larger == kUnbounded) return 1024;
  return mul_div_down(c.margin(), 1024, larger);
}

bool is_said_by_another(const Verdict& verdict, const Row& row) {
  const Attribute attribute = row.comparison.attribute;
  return std::ranges::any_of(verdict.rows, [&](const Row& other) {
    if (!is_unfit(other) || other.comparison.attribute != attribute) return false;
    if (row.against == Against::end_to_end)
      return other.against == Against::hop && other.user == row.user;
    return row.against == Against::hop && !row.is_user() && attribute == Attribute::bandwidth &&
           other.against == Against::medium_time && other.place == row.place;
  });
}

bool is_unknown_for_lateness(const Verdict& verdict, const Row& row) {
  const Attribute a = row.comparison.attribute;
  const bool is_time =
      a == Attribute::deadline || a == Attribute::latency || a == Attribute::jitter;
  if (row.is_user() || !is_time || is_unfit(row) || row.against == Against::schedule ||
      row.against == Against::traffic)
    return false;
  return std::ranges::any_of(verdict.rows, [&row](const Row& other) {
    return other.against == Against::schedule && is_unfit(other) &&
           (row.against != Against::hop || row.place == other.place);
  });
}

const Row* deciding_row(const Verdict& verdict) {
  if (!verdict.granted) return refusing_row(verdict);
  const Row* tightest = nullptr;
  for (const Row& row : verdict.rows) {
    if (row.against != Against::end_to_end || is_unfit(row)) continue;
    if (is_met_by_rule(row.comparison) || is_said_of_the_medium(verdict, row)) continue;
    if (tightest == nullptr || slack(row.comparison) < slack(tightest->comparison)) tightest = &row;
  }
  if (tightest != nullptr) return tightest;
  // An unfit row of a grant belongs to an alternative that would be available to others.
  const auto fit = std::ranges::find_if_not(verdict.rows, is_unfit);
  return fit == verdict.rows.end() ? nullptr : &*fit;
}

std::optional<Place> refusing_hop(const Verdict& verdict) {
  if (verdict.granted || verdict.obstacle == Obstacle::no_route ||
      verdict.obstacle == Obstacle::withdrawn)
    return std::nullopt;
  if (verdict.obstacle != Obstacle::none) return verdict.obstacle_at;
  const Row* const row = deciding_row(verdict);
  const bool is_of_hop =
      row != nullptr && row->against != Against::end_to_end && row->against != Against::traffic;
  return is_of_hop ? std::optional(row->place) : std::nullopt;
}

AttributeSet reaction_terms(const Verdict& verdict) {
  AttributeSet terms;
  for (const Attribute a : {Attribute::omission, Attribute::period})
    if (verdict.requirement.has(a)) terms.set(a, verdict.requirement[a]);
  for (const Attribute a : {Attribute::latency, Attribute::jitter})
    if (verdict.provision.has(a)) terms.set(a, verdict.provision[a]);
  // A Jitter that is not stated is bounded by the Latency.
  if (!terms.has(Attribute::jitter) && terms.has(Attribute::latency))
    terms.set(Attribute::jitter, terms[Attribute::latency]);
  return terms;
}

std::optional<Value> worst_case_reaction(const Verdict& verdict) {
  if (verdict.sporadic) return std::nullopt;
  const Value reaction = mlcca::worst_case_reaction(reaction_terms(verdict));
  if (reaction == kUnbounded) return std::nullopt;
  return reaction;
}

}  // namespace mlcca::core
