// SPDX-License-Identifier: BSD-2-Clause
// Chooses the route of each delivery, and decides a channel in one of its attribute sets.
#include "core/admission/admission.hpp"

#include <algorithm>
#include <utility>

#include "core/admission/echoes.hpp"
#include "core/admission/route_check.hpp"
#include "core/admission/senders.hpp"
#include "core/model/progress.hpp"
#include "mlcca/check.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {
namespace {

bool passes(const Route& route, auto gateway_is) {
  for (std::size_t i = 1; i + 1 < route.size(); ++i)
    if (route[i].kind == Place::Kind::gateway && gateway_is(route[i].index)) return true;
  return false;
}

/// Iterates over the routes that a delivery may take, the preferred one first. Most deliveries have
/// a single one; nothing is allocated for them.
class Ways {
 public:
  Ways(const Situation& s, const std::vector<Route>& routes) : s_(s), routes_(routes) {
    if (routes.size() == 1) return;
    const auto announces = [&s](std::size_t g) { return s.system.gateways[g].presence != 0; };
    elected_ = s.world.elects ||
               std::ranges::any_of(routes, [&](const Route& r) { return passes(r, announces); });
    // A failed gateway on the only possible routes has no replacement.
    avoids_failed_ =
        elected_ && !std::ranges::all_of(routes, [&](const auto& r) { return fails(r); });
  }

  /// Whether the gateways on the routes are elected, so that the choice must not depend on the
  /// past: all gateways that join the same networks choose the same one.
  [[nodiscard]] bool elected() const { return elected_; }
  [[nodiscard]] bool several() const { return behind(first()) != routes_.end(); }

  using Way = std::vector<Route>::const_iterator;
  [[nodiscard]] Way first() const { return next(routes_.begin()); }
  [[nodiscard]] Way behind(Way way) const { return next(std::next(way)); }
  [[nodiscard]] Way end() const { return routes_.end(); }

 private:
  [[nodiscard]] bool fails(const Route& route) const {
    return passes(route, [this](std::size_t g) { return s_.world.failed[g]; });
  }
  [[nodiscard]] Way next(Way from) const {
    return avoids_failed_
               ? std::find_if(from, routes_.end(), [this](const Route& r) { return !fails(r); })
               : from;
  }

  const Situation& s_;
  const std::vector<Route>& routes_;
  bool elected_ = false;
  bool avoids_failed_ = false;
};

/// Decides the deliveries of one channel, one after the other.
class Deliveries {
 public:
  /// `before`: see decide_in(). `barred`: gateways that may forward nothing that they would take
  /// from any sender.
  Deliveries(const Situation& s, Ledger& ledger, const std::vector<Target>& targets,
             const Decision* before, const std::vector<std::size_t>& barred)
      : s_(s),
        ledger_(ledger),
        targets_(targets),
        before_(before),
        barred_(barred),
        senders_(s.system, s.members) {}

  Verdict decide_as_before(Verdict start) {
    const Verdict* const old = before_ != nullptr ? same_delivery(*before_, start) : nullptr;
    const bool kept = old != nullptr && old->granted;
    const Ledger::Mark mark = ledger_.mark();
    // After a restart the former route is unknown.
    const Route* const way = kept && !old->route.empty() ? &old->route : nullptr;
    Verdict v = decide(std::move(start), way);
    if (v.granted && before_ != nullptr && !kept) {
      ledger_.roll_back(mark);
      v.granted = false;
    }
    return v;
  }

  /// Records the senders of a granted delivery for the decisions that follow.
  void note_granted(const Verdict& v) { senders_.add(v.publisher, v.route); }

 private:
  Verdict decide(Verdict first, const Route* preferred) {
    if (s_.withdrawn[first.channel]) {
      first.obstacle = Obstacle::withdrawn;
      return first;
    }
    const auto& routes = s_.topology.routes(s_.members.publisher(first.publisher).place, first.to);
    if (routes.empty()) {
      first.obstacle = Obstacle::no_route;
      return first;
    }
    const Ways ways(s_, routes);
    const auto best = ways.first();
    const Verdict start = ways.several() ? first : Verdict{};
    if (preferred != nullptr && !ways.elected() && *preferred != *best) {
      Verdict as_before = start;
      check(as_before, *preferred);
      if (as_before.granted) return as_before;
    }
    check(first, *best);
    for (auto way = ways.behind(best); way != ways.end() && !first.granted;
         way = ways.behind(way)) {
      Verdict other = start;
      check(other, *way);
      if (other.granted) return other;
    }
    return first;
  }

  void check(Verdict& v, const Route& route) {
    v.route = route;
    if (const auto conflict = senders_.conflict(v.publisher, route)) {
      const bool bus = s_.system.networks[conflict->network.index].kind == NetworkKind::can;
      v.obstacle = bus ? Obstacle::sender_twice : Obstacle::echo;
      v.obstacle_at = conflict->network;
    } else if (const auto barred = barred_on(v.publisher, route)) {
      v.obstacle = Obstacle::echo;
      v.obstacle_at = *barred;
    }
    check_route(s_, ledger_, targets_, v);
  }

  [[nodiscard]] std::optional<Place> barred_on(std::size_t publisher, const Route& route) const {
    for (const std::size_t gateway : barred_)
      if (takes_any_sender(s_.system, s_.members.publisher(publisher), route, gateway))
        return Place{Place::Kind::gateway, gateway};
    return std::nullopt;
  }

  const Situation& s_;
  Ledger& ledger_;
  const std::vector<Target>& targets_;
  const Decision* before_;
  const std::vector<std::size_t>& barred_;
  Senders senders_;
};

Decision decide_all(const Situation& situation, std::size_t channel, std::size_t set,
                    Deliveries deliveries, const std::vector<Target>& targets) {
  Decision decision;
  decision.set = set;
  const auto& publishers = situation.members.publishers_of(channel);
  decision.verdicts.reserve(targets.size() * publishers.size());
  for (const std::size_t publisher : publishers)
    for (const Target& target : targets) {
      const Verdict& v = decision.verdicts.emplace_back(
          deliveries.decide_as_before(undecided(situation, channel, publisher, target, set)));
      if (!v.granted) continue;
      ++decision.granted;
      if (targets.size() * publishers.size() > 1) deliveries.note_granted(v);
    }
  return decision;
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
  const std::vector<Target> targets = targets_of(situation.members, channel);
  std::vector<std::size_t> barred;
  for (;;) {
    const Ledger::Mark mark = ledger.mark();
    const std::size_t tried = situation.tried == nullptr ? 0 : situation.tried->size();
    Decision decision = decide_all(situation, channel, set,
                                   Deliveries(situation, ledger, targets, before, barred), targets);
    // Each round bars one more gateway from taking events from any sender. It ends because there is
    // no echo when all are barred.
    const auto echo = find_echo(situation.system, situation.members, decision.verdicts);
    if (!echo) return decision;
    ledger.roll_back(mark);
    if (situation.tried != nullptr) situation.tried->resize(tried);
    barred.push_back(*echo);
  }
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
