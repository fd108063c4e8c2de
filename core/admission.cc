// SPDX-License-Identifier: BSD-2-Clause
// Which route, and which of a channel's attribute sets.
#include "core/admission.hpp"

#include <algorithm>
#include <utility>

#include "core/route_check.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

std::vector<Target> targets_of(const Members& members, std::size_t channel) {
  std::vector<Target> targets;
  for (const std::size_t s : members.subscribers_of(channel)) {
    const Place place = members.subscriber(s).place;
    auto it = std::ranges::find(targets, place, &Target::place);
    if (it == targets.end()) it = targets.insert(targets.end(), {place, {}});
    it->subscribers.push_back(s);
  }
  return targets;
}

Verdict decide_one(const Situation& s, const Ledger& ledger, const std::vector<Target>& targets,
                   std::size_t channel, std::size_t publisher, const Target& target,
                   std::size_t set) {
  Verdict first = undecided(s, channel, publisher, target, set);
  if (s.released[channel]) {
    first.obstacle = Obstacle::released;
    return first;
  }
  const auto& routes = s.topology.routes(s.members.publisher(publisher).place, target.place);
  if (routes.empty()) {
    first.obstacle = Obstacle::no_route;
    return first;
  }
  const Verdict start = routes.size() > 1 ? first : Verdict{};
  first.route = routes.front();
  check_route(s, ledger, targets, first);
  for (std::size_t i = 1; i < routes.size() && !first.granted; ++i) {
    Verdict other = start;
    other.route = routes[i];
    check_route(s, ledger, targets, other);
    if (other.granted) return other;
  }
  return first;
}

/// The verdicts of a channel in one of its attribute sets, and the flows that they reserve.
struct Trial {
  std::vector<Verdict> verdicts;
  std::vector<std::pair<Flow, Value>> flows;
  std::size_t granted = 0;

  [[nodiscard]] bool all_granted() const { return granted == verdicts.size(); }
};

/// Promises what a granted verdict needs of each hop, unless its publisher has been promised it.
void reserve(const System& system, const Verdict& v, LedgerBuilder& builder, Trial& trial) {
  const auto hops = hops_of(v.route);
  for (std::size_t i = 0; i < hops.size(); ++i) {
    // A gateway without a stated rate has nothing to be shared.
    if (hops[i].kind == Place::Kind::gateway &&
        !system.provision_of(hops[i]).has(Attribute::bandwidth))
      continue;
    const Flow flow = flow_on(system, v.publisher, v.route, i);
    if (builder.add(flow, v.demand)) trial.flows.emplace_back(flow, v.demand);
  }
}

Trial decide_in(const Situation& s, std::size_t channel, const std::vector<Target>& targets,
                std::size_t set, LedgerBuilder& builder) {
  Trial trial;
  for (const std::size_t publisher : s.members.publishers_of(channel)) {
    for (const Target& target : targets) {
      Verdict v = decide_one(s, builder.ledger(), targets, channel, publisher, target, set);
      if (v.granted) {
        ++trial.granted;
        reserve(s.system, v, builder, trial);
      }
      trial.verdicts.push_back(std::move(v));
    }
  }
  return trial;
}

/// The preferred set in which everything is granted; if there is none, the one in which most is.
void decide_into(const Situation& s, std::size_t channel, LedgerBuilder& builder,
                 std::vector<Verdict>& verdicts) {
  const std::vector<Target> targets = targets_of(s.members, channel);
  const std::size_t sets = 1 + s.system.channels[channel].lower.size();
  Trial best = decide_in(s, channel, targets, 0, builder);
  for (std::size_t set = 1; set < sets && !best.all_granted(); ++set) {
    for (const auto& [flow, bytes] : best.flows) builder.remove(flow);
    Trial other = decide_in(s, channel, targets, set, builder);
    if (other.granted > best.granted) {
      best = std::move(other);
      continue;
    }
    for (const auto& [flow, bytes] : other.flows) builder.remove(flow);
    for (const auto& [flow, bytes] : best.flows) builder.add(flow, bytes);
  }
  verdicts = std::move(best.verdicts);
}

}  // namespace

ChannelDecision decide(const Situation& situation, std::size_t channel, const Ledger& before) {
  LedgerBuilder builder(before);
  std::vector<Verdict> verdicts;
  decide_into(situation, channel, builder, verdicts);
  return {std::move(verdicts), std::move(builder).take()};
}

Ledger decide_each(const Situation& situation, const EachChannel& each) {
  LedgerBuilder builder(Ledger(situation.system.resources()));
  for (std::size_t c = 0; c < situation.system.channels.size(); ++c) {
    std::vector<Verdict> verdicts;
    decide_into(situation, c, builder, verdicts);
    each(c, std::move(verdicts), builder.ledger());
  }
  return std::move(builder).take();
}

Decision decide_all(const Situation& situation) {
  Decision decision;
  decision.channels.resize(situation.system.channels.size());
  decision.ledger = decide_each(
      situation, [&](std::size_t channel, std::vector<Verdict> verdicts, const Ledger&) {
        decision.channels[channel] = std::move(verdicts);
      });
  return decision;
}

}  // namespace mlcca::core
