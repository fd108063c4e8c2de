// SPDX-License-Identifier: BSD-2-Clause
// Which route, and which of a channel's attribute sets.
#include "core/admission/admission.hpp"

#include <algorithm>
#include <utility>

#include "core/admission/route_check.hpp"
#include "core/model/progress.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

Verdict decide_one(const Situation& s, Ledger& ledger, const std::vector<Target>& targets,
                   Verdict first, const Route* preferred) {
  if (s.withdrawn[first.channel]) {
    first.obstacle = Obstacle::withdrawn;
    return first;
  }
  const auto& routes = s.topology.routes(s.members.publisher(first.publisher).place, first.to);
  if (routes.empty()) {
    first.obstacle = Obstacle::no_route;
    return first;
  }
  const Verdict start = routes.size() > 1 ? first : Verdict{};
  if (preferred != nullptr && *preferred != routes.front()) {
    Verdict as_before = start;
    as_before.route = *preferred;
    check_route(s, ledger, targets, as_before);
    if (as_before.granted) return as_before;
  }
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

}  // namespace

const Verdict* same_delivery(const Decision& decision, const Verdict& v) {
  const auto it = std::ranges::find_if(decision.verdicts, [&v](const Verdict& o) {
    return o.publisher == v.publisher && o.to == v.to;
  });
  return it == decision.verdicts.end() ? nullptr : &*it;
}

Decision decide_in(const Situation& situation, std::size_t channel, std::size_t set, Ledger& ledger,
                   const Decision* before) {
  Progress::made();
  Decision decision;
  decision.set = set;
  const std::vector<Target> targets = targets_of(situation.members, channel);
  for (const std::size_t publisher : situation.members.publishers_of(channel)) {
    for (const Target& target : targets) {
      Verdict start = undecided(situation, channel, publisher, target, set);
      const Verdict* old = before != nullptr ? same_delivery(*before, start) : nullptr;
      const bool kept = old != nullptr && old->granted;
      const Ledger::Mark mark = ledger.mark();
      // Of what was granted before a restart the way is not known any more.
      const Route* way = kept && !old->route.empty() ? &old->route : nullptr;
      Verdict v = decide_one(situation, ledger, targets, std::move(start), way);
      if (v.granted && before != nullptr && !kept) {
        ledger.roll_back(mark);
        v.granted = false;
      }
      if (v.granted) ++decision.granted;
      decision.verdicts.push_back(std::move(v));
    }
  }
  return decision;
}

void renew_responses(const Situation& situation, Ledger& ledger, Decision& decision) {
  if (decision.verdicts.empty()) return;
  const std::vector<Target> targets =
      targets_of(situation.members, decision.verdicts.front().channel);
  for (Verdict& v : decision.verdicts) renew_responses(situation, ledger, targets, v);
}

std::size_t sets_of(const System& system, std::size_t channel) {
  return 1 + system.channels[channel].lower.size();
}

bool keeps_grants(const Decision& before, const Decision& after) {
  return std::ranges::all_of(before.verdicts, [&](const Verdict& old) {
    const Verdict* now = same_delivery(after, old);
    return !old.granted || (now != nullptr && now->granted);
  });
}

}  // namespace mlcca::core
