// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/onward.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/admission/route_check.hpp"
#include "core/admission/state.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"
#include "mlcca/union.hpp"

namespace mlcca::core {
namespace {

/// Solves the composition of an attribute for the part before, given the part that is used behind.
Value left_of(Composition composition, Value required, Value used) {
  switch (composition) {
    case Composition::sum:
    case Composition::not_provided:
      return required > used ? required - used : 0;
    case Composition::consecutive:
      if (required == kUnbounded) return required;
      if (used >= required) return 0;
      return (required + 1) / (used + 1) - 1;
    case Composition::survival:
      if (required >= kCertainLoss) return required;
      if (used >= required) return 0;
      return (required - used) * kCertainLoss / (kCertainLoss - used);
    case Composition::slowest:
    case Composition::shared_medium:
    case Composition::smallest:
      break;
  }
  return required;
}

}  // namespace

AttributeSet requirement_before(const AttributeSet& requirement, const AttributeSet& used) {
  AttributeSet out = requirement;
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (!requirement.has(a)) continue;
    // A Deadline is held against the Latency. An attribute that the hops behind do not state counts
    // as unbounded.
    const Attribute held = held_against(a);
    out.set(a,
            left_of(info(a).composition, requirement[a], used.has(held) ? used[held] : kUnbounded));
  }
  return out;
}

namespace {

/// Where a granted delivery enters the gateway.
struct WayIn {
  std::size_t hop = 0;        ///< index of the incoming network among the hops
  bool is_described = false;  ///< another gateway with the same description comes before
};
/// Nullopt if the delivery starts at the gateway or does not pass it.
std::optional<WayIn> way_in(const Verdict& v, std::size_t gateway) {
  const auto at = std::ranges::find(v.route, Place{Place::Kind::gateway, gateway});
  if (at == v.route.begin() || at == v.route.end()) return std::nullopt;
  const auto hops = hops_of(v.route);
  const auto network = std::ranges::find(hops, *std::prev(at));
  if (network == hops.end() || network->kind != Place::Kind::network) return std::nullopt;
  const bool by_another = std::any_of(
      v.route.begin(), at, [](const Place& place) { return place.kind == Place::Kind::gateway; });
  return WayIn{static_cast<std::size_t>(network - hops.begin()), by_another};
}

/// Why the delivery, which is number `n` of its channel, cannot be passed on; empty if it can.
std::string keeps_back(const Verdict& v, std::size_t n) {
  if (n > kMostOnward) return "it has more than " + std::to_string(kMostOnward) + " deliveries";
  if (v.user_requirement.empty()) return {};
  return "it requires a user-defined attribute, which a subscription does not state";
}

/// Adds the subscribers of the delivery on whose behalf the gateway subscribes. Returns false if
/// there are none, because the gateway before knows all of them by its description.
bool note_subscribers(const Members& members, const Verdict& v, const WayIn& in,
                      OnwardSubscription& to) {
  bool any = false;
  for (const std::size_t s : v.subscribers) {
    const AdmissionId admission = members.admission_of_subscriber(s);
    if (admission == 0 && in.is_described) continue;
    any = true;
    if (admission == 0)
      to.described = true;
    else
      to.admitted.push_back(admission);
  }
  return any;
}

}  // namespace

std::vector<OnwardSubscription> onward_of(State& state, std::size_t gateway, std::size_t channel) {
  std::map<std::size_t, OnwardSubscription> by_network;
  std::size_t seen = 0;
  for (const Verdict& v : state.decisions()[channel].verdicts) {
    const auto in = v.granted ? way_in(v, gateway) : std::nullopt;
    if (!in) continue;
    const std::size_t network = hops_of(v.route)[in->hop].index;
    if (state.system().networks[network].subscriptions.accept < Subscribing::with_attributes)
      continue;
    OnwardSubscription fresh{channel, network, {}};
    const auto known = by_network.find(network);
    if (!note_subscribers(state.members(), v, *in,
                          known == by_network.end() ? fresh : known->second))
      continue;
    OnwardSubscription& one = by_network.try_emplace(network, std::move(fresh)).first->second;
    if (auto why = keeps_back(v, ++seen); !why.empty()) one.problem = std::move(why);
    if (!one.problem.empty()) continue;
    const auto hops = state.hops_of_granted(v);
    if (hops.size() <= in->hop) continue;
    const std::size_t behind = hops.size() - in->hop - 1;
    one.required = strictest(
        one.required,
        behind == 0
            ? v.requirement
            : requirement_before(v.requirement, compose(hops.data() + in->hop + 1, behind, 0)));
  }
  std::vector<OnwardSubscription> out;
  out.reserve(by_network.size());
  for (auto& [network, one] : by_network) out.push_back(std::move(one));
  return out;
}

}  // namespace mlcca::core
