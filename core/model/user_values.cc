// SPDX-License-Identifier: BSD-2-Clause
#include "core/model/user_values.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

const UserValue* find(const UserValues& values, std::uint32_t attribute) {
  const auto it = std::ranges::lower_bound(values, attribute, {}, &UserValue::attribute);
  return it != values.end() && it->attribute == attribute ? &*it : nullptr;
}

/// What a gateway provides where it states nothing: no limit, for compositions that have such a
/// value.
std::optional<Value> no_limit(Composition composition) {
  Value value = 0;
  if (!unlimited_by_gateway(composition, &value)) return std::nullopt;
  return value;
}

std::optional<UserValue> composed_one(const UserAttribute& info, std::uint32_t attribute,
                                      std::span<const UserHop> hops) {
  std::array<HopValue, kMaxHops> values{};
  UserValue out{attribute, false, 0};
  for (std::size_t i = 0; i < hops.size(); ++i) {
    const UserValue* stated = find(*hops[i].provision, attribute);
    const auto unstated = hops[i].gateway ? no_limit(info.composition) : std::nullopt;
    if (stated == nullptr && !unstated) return std::nullopt;
    values[i].value = stated != nullptr ? stated->value : *unstated;
    values[i].frames = static_cast<std::uint16_t>(hops[i].frames);
    out.dynamic = out.dynamic || (stated != nullptr && stated->dynamic);
  }
  out.value = compose_values(info.composition, values.data(), hops.size());
  return out;
}

}  // namespace

UserValues strictest(const System& system, const UserValues& a, const UserValues& b) {
  UserValues out;
  const auto harder = [&](const UserValue& x, const UserValue& y) {
    return satisfies(system.user_attributes[x.attribute].better, x.value, y.value) ? x : y;
  };
  for (const UserValue& x : a) {
    const UserValue* y = find(b, x.attribute);
    out.push_back(y == nullptr ? x : harder(x, *y));
  }
  for (const UserValue& y : b)
    if (find(a, y.attribute) == nullptr) out.push_back(y);
  std::ranges::sort(out, {}, &UserValue::attribute);
  return out;
}

UserValues composed(const System& system, std::span<const UserHop> hops) {
  UserValues out;
  if (hops.empty() || hops.size() > kMaxHops) return out;
  for (std::uint32_t a = 0; a < system.user_attributes.size(); ++a)
    if (const auto value = composed_one(system.user_attributes[a], a, hops)) out.push_back(*value);
  return out;
}

Comparison compare(const System& system, const UserValue& required, const UserValues& provision) {
  Comparison row;
  row.required = required.value;
  const UserValue* provided = find(provision, required.attribute);
  row.known = provided != nullptr;
  if (!row.known) return row;
  row.dynamic = provided->dynamic;
  row.provided = provided->value;
  const Better better = system.user_attributes[required.attribute].better;
  if (satisfies(better, row.provided, row.required))
    row.outcome = row.dynamic ? Outcome::run_time : Outcome::fit;
  return row;
}

}  // namespace mlcca::core
