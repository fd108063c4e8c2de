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

/// Each composition of the table is turned round.
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
    // A Deadline is held against the Latency. What the hops behind do not state, they do not give.
    const Attribute held = held_against(a);
    out.set(a,
            left_of(info(a).composition, requirement[a], used.has(held) ? used[held] : kUnbounded));
  }
  return out;
}

namespace {

/// Where on its way a granted delivery comes to the gateway: the number of the network among its
/// hops. Nothing: it begins there, or does not come by it.
std::optional<std::size_t> hop_before(const Verdict& v, std::size_t gateway) {
  const auto at = std::ranges::find(v.route, Place{Place::Kind::gateway, gateway});
  if (at == v.route.begin() || at == v.route.end()) return std::nullopt;
  const auto hops = hops_of(v.route);
  const auto network = std::ranges::find(hops, *std::prev(at));
  if (network == hops.end() || network->kind != Place::Kind::network) return std::nullopt;
  return static_cast<std::size_t>(network - hops.begin());
}

}  // namespace

std::vector<Hop> State::hops_of_granted(const Verdict& v) {
  Situation measuring = situation();
  measuring.keeps_hops = true;
  Verdict again = undecided(measuring, v.channel, v.publisher, {v.to, v.subscribers}, v.set);
  again.route = v.route;
  const Ledger::Mark before = ledger_.mark();
  check_route(measuring, ledger_, targets_of(members_, v.channel), again);
  ledger_.roll_back(before);
  return std::move(again.hops);
}

std::vector<OnwardSubscription> State::onward(std::size_t gateway, std::size_t channel) {
  std::map<std::size_t, OnwardSubscription> by_network;
  std::size_t seen = 0;
  for (const Verdict& v : decisions_[channel].verdicts) {
    const bool came = std::ranges::any_of(
        v.subscribers, [&](std::size_t s) { return members_.admission_of_subscriber(s) != 0; });
    const auto at = v.granted && came ? hop_before(v, gateway) : std::nullopt;
    if (!at) continue;
    const std::size_t network = hops_of(v.route)[*at].index;
    if (system_.networks[network].subscriptions.accept < Subscribing::with_attributes) continue;
    OnwardSubscription& one =
        by_network.try_emplace(network, OnwardSubscription{channel, network, {}}).first->second;
    if (!v.user_requirement.empty())
      one.problem = "it requires a user-defined attribute, which a subscription does not state";
    if (++seen > kMostOnward)
      one.problem = "it has more than " + std::to_string(kMostOnward) + " deliveries";
    if (!one.problem.empty()) continue;
    const auto hops = hops_of_granted(v);
    if (hops.size() <= *at) continue;
    const std::size_t behind = hops.size() - *at - 1;
    one.required = strictest(
        one.required,
        behind == 0 ? v.requirement
                    : requirement_before(v.requirement, compose(hops.data() + *at + 1, behind, 0)));
  }
  std::vector<OnwardSubscription> out;
  out.reserve(by_network.size());
  for (auto& [network, one] : by_network) out.push_back(std::move(one));
  return out;
}

}  // namespace mlcca::core
