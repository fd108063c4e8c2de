// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/footprint.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "core/admission/permit_check.hpp"
#include "core/admission/permits.hpp"
#include "core/admission/route_check.hpp"
#include "core/can/cover.hpp"

namespace mlcca::core::cluster {
namespace {

/// What one flow holds of a shared network.
struct Held {
  Value bytes_per_second = 0;
  const can::Message* message = nullptr;
  std::vector<PathPart> paths;
};

void add_others(const Verdict& v, std::size_t self, std::set<std::size_t>& to) {
  for (const Place place : v.route)
    if (place.kind == Place::Kind::gateway && place.index != self) to.insert(place.index);
}

bool is_covered(const Standing* standing, const Held& held) {
  if (standing == nullptr || standing->bytes_per_second < held.bytes_per_second) return false;
  if (held.message != nullptr &&
      (!standing->message || !can::covers(*standing->message, *held.message)))
    return false;
  return std::ranges::all_of(held.paths, [&](const PathPart& path) {
    return std::ranges::any_of(standing->paths, [&](const PathPart& p) { return covers(p, path); });
  });
}

class Collector {
 public:
  Collector(const State& state, const Baseline& baseline, std::size_t self)
      : state_(state), baseline_(baseline), self_(self) {}

  void take(const Verdict& v) {
    if (!v.granted) return;
    add_others(v, self_, gateways_);
    const auto hops = hops_of(v.route);
    for (std::size_t i = 0; i < hops.size(); ++i)
      if (hops[i].kind == Place::Kind::network && state_.world().shared[hops[i].index]) take(v, i);
  }

  [[nodiscard]] Footprint footprint() && {
    Footprint out;
    for (auto& [flow, held] : all_) {
      const bool described = state_.members().admission_of_publisher(flow.publisher) == 0;
      if (described && is_covered(baseline_.find(flow), held)) continue;
      if (!described && is_reserved_by_another(flow, held)) continue;
      add(part_of(out, flow.resource), flow, std::move(held));
    }
    std::ranges::sort(out.parts, {}, &Part::network);
    out.gateways.assign(gateways_.begin(), gateways_.end());
    return out;
  }

 private:
  void take(const Verdict& v, std::size_t hop) {
    const Flow flow = flow_on(state_.system(), v.publisher, v.route, hop);
    Held& held = all_[flow];
    held.bytes_per_second = std::max(held.bytes_per_second, v.demand);
    held.message = state_.ledger().message_of(flow);
    for (const PathPart& path : paths_on(state_.system(), state_.members(), v, hop))
      if (std::ranges::find(held.paths, path) == held.paths.end()) held.paths.push_back(path);
  }

  [[nodiscard]] bool is_reserved_by_another(const Flow& flow, const Held& held) const {
    const Permits* const permits = state_.permits();
    return permits != nullptr &&
           permits->is_reserved_by_another({.network = flow.resource,
                                            .source = source_of(state_.members(), flow),
                                            .bytes_per_second = held.bytes_per_second,
                                            .message = held.message,
                                            .paths = held.paths});
  }

  static Part& part_of(Footprint& out, std::size_t network) {
    const auto it = std::ranges::find(out.parts, network, &Part::network);
    if (it != out.parts.end()) return *it;
    out.parts.emplace_back().network = network;
    return out.parts.back();
  }

  void add(Part& part, const Flow& flow, Held held) const {
    part.rates.push_back(
        {.bytes_per_second = held.bytes_per_second, .source = source_of(state_.members(), flow)});
    if (held.message != nullptr)
      part.bus.push_back(bus_part_of(state_.system(), state_.members(), flow, *held.message));
    std::ranges::move(held.paths, std::back_inserter(part.paths));
  }

  const State& state_;
  const Baseline& baseline_;
  std::size_t self_;
  std::map<Flow, Held> all_;
  std::set<std::size_t> gateways_;
};

Footprint collected(const State& state, std::span<const Verdict* const> deliveries,
                    const Baseline& baseline, std::size_t self) {
  Collector collector(state, baseline, self);
  for (const Verdict* const v : deliveries) collector.take(*v);
  return std::move(collector).footprint();
}

std::vector<const Verdict*> all_of(const Decision& decision) {
  std::vector<const Verdict*> all;
  all.reserve(decision.verdicts.size());
  for (const Verdict& v : decision.verdicts) all.push_back(&v);
  return all;
}

bool is_granted_now(const Decision& now, const Verdict& v) {
  const Verdict* const same = same_delivery(now, v);
  return same != nullptr && same->granted;
}

}  // namespace

Footprint footprint_of(const Proposal& proposal, std::span<const Verdict* const> deliveries,
                       const Baseline& baseline, std::size_t self) {
  return collected(proposal.state(), deliveries, baseline, self);
}

Footprint footprint_of(const Proposal& proposal, const Baseline& baseline, std::size_t self) {
  const Decision& next = proposal.decision();
  if (!proposal.has_newcomer()) return collected(proposal.state(), all_of(next), baseline, self);
  const Decision& now = proposal.state().decisions()[proposal.channel()];
  std::vector<const Verdict*> deliveries = proposal.verdicts();
  if (next.set != now.set)
    for (const Verdict& v : next.verdicts)
      if (is_granted_now(now, v)) deliveries.push_back(&v);
  return collected(proposal.state(), deliveries, baseline, self);
}

Footprint footprint_of(const State& state, std::size_t channel, const Baseline& baseline,
                       std::size_t self) {
  return collected(state, all_of(state.decisions()[channel]), baseline, self);
}

Footprint footprint_of(const State& state, std::span<const Verdict* const> deliveries,
                       const Baseline& baseline, std::size_t self) {
  return collected(state, deliveries, baseline, self);
}

void add_gateway(Footprint& footprint, std::size_t gateway) {
  auto& all = footprint.gateways;
  const auto at = std::ranges::lower_bound(all, gateway);
  if (at == all.end() || *at != gateway) all.insert(at, gateway);
}

std::vector<Want> wants_of(const Proposal& wish, std::size_t self) {
  const Decision& next = wish.decision();
  const Decision& now = wish.state().decisions()[wish.channel()];
  const bool is_another_set = now.granted != 0 && next.set != now.set;
  std::vector<Want> wants;
  for (const Verdict& v : next.verdicts) {
    if (!v.granted || (!is_another_set && is_granted_now(now, v)) || wish.state().is_permitted(v))
      continue;
    std::set<std::size_t> others;
    add_others(v, self, others);
    std::vector<std::size_t> gateways(others.begin(), others.end());
    if (is_another_set && !wants.empty()) {
      others.insert(wants.front().gateways.begin(), wants.front().gateways.end());
      wants.front().gateways.assign(others.begin(), others.end());
      wants.front().deliveries.push_back(&v);
      continue;
    }
    const auto same = std::ranges::find(wants, gateways, &Want::gateways);
    if (same == wants.end())
      wants.push_back({.gateways = std::move(gateways), .deliveries = {&v}});
    else
      same->deliveries.push_back(&v);
  }
  return wants;
}

void add(Foreign& foreign, const Part& part, std::size_t gateway) {
  const auto append = [gateway](const auto& from, auto& to) {
    for (const auto& one : from) to.emplace_back(one).gateway = gateway;
  };
  append(part.rates, foreign.rates);
  append(part.bus, foreign.bus);
  append(part.paths, foreign.paths);
}

}  // namespace mlcca::core::cluster
