// SPDX-License-Identifier: BSD-2-Clause
#include "core/design/contest.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "core/admission/allocation.hpp"
#include "core/admission/route_check.hpp"
#include "core/admission/sharing.hpp"
#include "core/admission/world.hpp"
#include "core/design/room.hpp"

namespace mlcca::core {
namespace {

/// The most channels that are decided to find out what the best cases of one group do. A group of n
/// channels is decided 2^q times if q best cases matter.
constexpr std::size_t kMostDecided = 4000;

bool is_at_best(const Decision& decision) {
  return std::ranges::any_of(decision.verdicts,
                             [](const Verdict& v) { return v.outcome == Outcome::run_time; });
}

/// Whether the same is granted, over the same routes in the same attribute set.
bool grants_the_same(const Decision& a, const Decision& b) {
  return a.set == b.set &&
         std::ranges::equal(a.verdicts, b.verdicts, [](const auto& x, const auto& y) {
           return x.granted == y.granted && (!x.granted || x.route == y.route);
         });
}

/// Whether this delivery may be granted if another one of the channel is not.
bool may_be_beside_another(const Decision& decision, const Verdict& v) {
  if (v.obstacle == Obstacle::sender_twice || v.obstacle == Obstacle::echo) return true;
  return !v.granted && decision.granted != 0 && std::ranges::any_of(v.rows, is_for_want_of_room);
}

bool is_held_up_by_itself(const Decision& decision) {
  return std::ranges::any_of(decision.verdicts, [&decision](const Verdict& v) {
    return may_be_beside_another(decision, v);
  });
}

/// Marks a verdict as open. A granted one gets the rows about lack of room that it has in the cases
/// in which it is refused.
void leave_open_for(Verdict& v, const Verdict* refused) {
  v.contested = true;
  v.outcome = Outcome::run_time;
  if (refused != nullptr && std::ranges::none_of(v.rows, is_for_want_of_room))
    std::ranges::copy_if(refused->rows, std::back_inserter(v.rows), is_for_want_of_room);
}

}  // namespace

/// Enumerates all combinations of answers to the questions that are asked, depth first, yes before
/// no. A repeated question gets the same answer.
class Contest::Answers {
 public:
  bool operator()(const Verdict& v) {
    const auto [it, fresh] =
        place_of_.try_emplace({v.publisher, v.to, v.set, v.route}, given_.size());
    if (fresh) given_.emplace_back(it, true);
    return given_[it->second].second;
  }
  /// Goes to the next combination; returns false if there are no more.
  bool advance() {
    while (!given_.empty() && !given_.back().second) {
      place_of_.erase(given_.back().first);
      given_.pop_back();
    }
    if (given_.empty()) return false;
    given_.back().second = false;
    return true;
  }

 private:
  using Places = std::map<Question, std::size_t>;
  Places place_of_;
  std::vector<std::pair<Places::iterator, bool>> given_;
};

struct Contest::Range {
  std::vector<bool> ever;                       ///< by delivery: granted in some case
  std::vector<bool> always;                     ///< by delivery: granted in all cases
  std::vector<std::optional<Verdict>> refused;  ///< by delivery: a refusal that names the lack of
                                                ///< room
  std::set<std::size_t> sets;

  void add(const Decision& decision) {
    const std::size_t count = decision.verdicts.size();
    if (decision.granted != 0) sets.insert(decision.set);
    ever.resize(count, false);
    always.resize(count, true);
    refused.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Verdict& v = decision.verdicts[i];
      ever[i] = ever[i] || v.granted;
      always[i] = always[i] && v.granted;
      if (!v.granted && !refused[i] && std::ranges::any_of(v.rows, is_for_want_of_room))
        refused[i] = v;
    }
  }
};

Contest::Contest(const Situation& situation)
    : s_(situation),
      ledger_(empty_ledger(situation.system, situation.world)),
      tried_(situation.system.channels.size()),
      uncertain_(situation.system.channels.size(), false) {}

std::vector<std::size_t> Contest::mark(Decisions& decisions) {
  bool any = false;
  for (const auto& [channel, decision] : decisions) {
    uncertain_[channel] = is_at_best(decision);
    any = any || uncertain_[channel];
  }
  if (!any) return {};
  find_users();
  std::vector<bool> marked(s_.system.channels.size(), false);
  for (auto& [channel, decision] : decisions) {
    if (!uncertain_[channel] || marked[channel]) continue;
    const auto sharing = sharing_with(
        channel, [this](std::size_t c) -> const auto& { return shared_[c]; },
        [this](std::size_t resource) -> const auto& { return users_.at(resource); });
    const std::vector<std::size_t> together(sharing.begin(), sharing.end());
    for (const std::size_t c : together) marked[c] = true;
    mark_together(together, decisions);
  }
  return {open_sets_.begin(), open_sets_.end()};
}

/// Whether the resource has a limit that its channels share.
bool Contest::is_limited(std::size_t resource) const {
  const std::size_t networks = s_.system.networks.size();
  if (resource >= networks)
    return s_.system.gateways[resource - networks].provision.has(Attribute::bandwidth);
  return ledger_.schedule(resource) != nullptr || s_.world.meshes[resource] != nullptr ||
         s_.system.networks[resource].provision.has(Attribute::bandwidth);
}

/// The limited resources of all routes that the channel's events may take.
std::vector<std::size_t> Contest::shared_by(std::size_t channel) const {
  std::set<std::size_t> all;
  for (const std::size_t p : s_.members.publishers_of(channel))
    for (const Target& target : targets_of(s_.members, channel))
      for (const Route& route : s_.topology.routes(s_.members.publisher(p).place, target.place))
        for (const Place hop : hops_of(route))
          if (is_limited(s_.system.resource_of(hop))) all.insert(s_.system.resource_of(hop));
  return {all.begin(), all.end()};
}

void Contest::find_users() {
  shared_.resize(s_.system.channels.size());
  for (std::size_t c = 0; c < shared_.size(); ++c) {
    shared_[c] = shared_by(c);
    for (const std::size_t resource : shared_[c]) users_[resource].push_back(c);
  }
}

/// Settles channels that share resources, by the cheapest method that decides them.
void Contest::mark_together(const std::vector<std::size_t>& channels, Decisions& decisions) {
  if (have_room_together(channels, decisions) || try_all(channels, decisions)) return;
  leave_open(channels, decisions);
}

/// Removes what was reserved for trying.
void Contest::take_out(const std::vector<std::size_t>& channels) {
  for (const std::size_t c : channels)
    for (const std::size_t p : s_.members.publishers_of(c)) ledger_.remove(p);
  ledger_.commit();
}

/// Whether the channel gets no more even if no other channel existed.
bool Contest::gets_all_that_it_can(std::size_t channel, const Decision& decision) {
  decide_some(s_, {channel}, tried_, ledger_);
  take_out({channel});
  return grants_the_same(tried_[channel], decision);
}

/// Whether the channel's grants fit beside what is held already; if it depends on best cases, over
/// each of its routes.
bool Contest::holds_all_ways(std::size_t channel, const Decision& decision) {
  const std::vector<Target> targets = targets_of(s_.members, channel);
  for (const Verdict& v : decision.verdicts) {
    if (!v.granted) continue;
    const auto target = std::ranges::find(targets, v.to, &Target::place);
    for (const Route& route : s_.topology.routes(s_.members.publisher(v.publisher).place, v.to)) {
      if (!uncertain_[channel] && route != v.route) continue;
      Verdict one = undecided(s_, channel, v.publisher, *target, decision.set);
      one.route = route;
      check_route(s_, ledger_, targets, one);
      const bool for_room = std::ranges::any_of(one.rows, is_for_want_of_room) || route == v.route;
      if (!one.granted && for_room) return false;
    }
  }
  return true;
}

/// Whether everything that these channels may ever hold fits at once. Then it does not matter which
/// of them hold it.
bool Contest::have_room_together(const std::vector<std::size_t>& channels,
                                 const Decisions& decisions) {
  for (const std::size_t c : channels) {
    const auto found = decisions.find(c);
    if (found == decisions.end()) continue;
    if (uncertain_[c] && (sets_of(s_.system, c) > 1 || is_held_up_by_itself(found->second)))
      return false;
    if (!gets_all_that_it_can(c, found->second)) return false;
  }
  bool fits = true;
  for (const std::size_t c : channels) {
    const auto found = decisions.find(c);
    if (found == decisions.end()) {
      decide_some(s_, {c}, tried_, ledger_);
      continue;
    }
    fits = fits && holds_all_ways(c, found->second);
  }
  take_out(channels);
  return fits;
}

/// Tries all cases; returns false if there are too many.
bool Contest::try_all(const std::vector<std::size_t>& channels, Decisions& decisions) {
  std::map<std::size_t, Range> ranges;
  Answers answers;
  const BestCasesHold hold = [&answers](const Verdict& v) { return answers(v); };
  Situation situation = s_;
  situation.hold = &hold;
  std::size_t decided = 0;
  do {
    decided += channels.size();
    if (decided > kMostDecided) return false;
    decide_some(situation, channels, tried_, ledger_);
    take_out(channels);
    for (const std::size_t c : channels) ranges[c].add(tried_[c]);
  } while (answers.advance());
  for (const std::size_t c : channels) {
    const auto found = decisions.find(c);
    if (found == decisions.end()) continue;
    const Range& range = ranges[c];
    if (range.sets.size() > 1) open_sets_.insert(c);
    for (std::size_t i = 0; i < found->second.verdicts.size(); ++i) {
      Verdict& v = found->second.verdicts[i];
      const bool differs = range.ever[i] != range.always[i];
      if (differs && v.outcome != Outcome::run_time)
        leave_open_for(v, range.refused[i] ? &*range.refused[i] : nullptr);
    }
  }
  return true;
}

/// Handles groups with too many cases: everything that is granted, or that a channel would get if
/// it were alone, is decided at run time.
void Contest::leave_open(const std::vector<std::size_t>& channels, Decisions& decisions) {
  for (const std::size_t c : channels) {
    const auto found = decisions.find(c);
    if (found == decisions.end()) continue;
    if (sets_of(s_.system, c) > 1) open_sets_.insert(c);
    std::vector<bool> ever(found->second.verdicts.size(), false);
    for (std::size_t set = 0; set < sets_of(s_.system, c); ++set) {
      const Decision alone = decide_in(s_, c, set, ledger_);
      take_out({c});
      for (std::size_t i = 0; i < alone.verdicts.size(); ++i)
        ever[i] =
            ever[i] || alone.verdicts[i].granted || may_be_beside_another(alone, alone.verdicts[i]);
    }
    for (std::size_t i = 0; i < ever.size(); ++i) {
      Verdict& v = found->second.verdicts[i];
      if (v.outcome != Outcome::run_time && (v.granted || ever[i])) leave_open_for(v, nullptr);
    }
  }
}

}  // namespace mlcca::core
