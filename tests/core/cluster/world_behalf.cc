// SPDX-License-Identifier: BSD-2-Clause
// Admissions that gateway 0 makes for another gateway, as the daemon makes them.
#include <algorithm>

#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

bool World::makes_for_others(std::size_t g) const { return scenario_->behalf && g == 0; }

/// Which admission of another gateway the own one with that id is made for; null: none.
const Origin* World::made_for(std::size_t g, std::uint64_t id) const {
  const auto it = std::ranges::find_if(hosts_[g].behalf,
                                       [id](const auto& entry) { return entry.second == id; });
  return it == hosts_[g].behalf.end() ? nullptr : &it->first;
}

/// The answer to the own one is the vote on the other one.
void World::vote_as(std::size_t g, std::uint64_t id, bool ok) {
  const Origin* const origin = made_for(g, id);
  if (origin == nullptr || (!ok && scenario_->mutant == Mutant::kept_after_its_end)) return;
  if (ok) made_.emplace(origin->gateway, origin->id);
  hosts_[g].member->vote(
      *origin, {.ok = ok, .hop = {}, .reason = ok ? "" : "no", .final = !ok && gone_}, clock(g));
}

/// Asked for when no other one is decided. What a former process has asked for goes on.
void World::step_behalf(std::size_t g) {
  Host& host = hosts_[g];
  for (auto& [origin, id] : host.behalf) {
    if (id != 0 || !host.agreed.contains(origin) || !host.member->why_not(clock(g)).empty())
      continue;
    if (fits(g) && !gone_) {
      id = host.next_id++;
      ask(g, id, {origin.gateway});
    } else {
      host.member->vote(origin, {.ok = false, .hop = {}, .reason = "no", .final = gone_}, clock(g));
      host.agreed.erase(origin);
    }
    return;
  }
}

void World::adopt_behalf(std::size_t g, const Origin& origin) {
  Host& host = hosts_[g];
  host.agreed[origin] = true;
  const std::uint64_t id = host.behalf[origin];
  if (host.held.contains(id))
    vote_as(g, id, true);
  else
    host.behalf[origin] = 0;
  if (scenario_->mutant == Mutant::agreed_at_once)
    host.member->vote(origin, {.ok = true, .hop = {}, .reason = {}}, clock(g));
}

void World::end_behalf(std::size_t g, const Origin& origin) {
  Host& host = hosts_[g];
  const auto it = host.behalf.find(origin);
  if (it == host.behalf.end()) return;
  const std::uint64_t id = it->second;
  host.behalf.erase(it);
  // What is not answered yet is released when it is.
  if (id == 0 || host.held.erase(id) == 0) return;
  close(g, {g, id});
  host.member->release(id, clock(g));
}

/// What a former process has made for others that do not ask for it any more.
void World::end_strange_behalf(std::size_t g) {
  for (const auto& [origin, id] : std::map(hosts_[g].behalf))
    if (!hosts_[g].agreed.contains(origin)) end_behalf(g, origin);
}

/// When all is well, what another gateway was granted is made for it and open at both.
void World::check_behalf() {
  if (!scenario_->behalf) return;
  for (const std::uint64_t id : hosts_[1].held) {
    const auto made = std::ranges::find_if(hosts_[0].behalf, [id](const auto& entry) {
      return entry.first.gateway == 1 && entry.first.id == id;
    });
    const auto open = [&](std::size_t g) {
      const auto gate = hosts_[g].gates.find({0, made->second});
      return gate != hosts_[g].gates.end() && gate->second.open;
    };
    if (made == hosts_[0].behalf.end() || !open(0) || !open(1))
      broken_ = "what was granted for another gateway has ended, and it does not know";
  }
}

}  // namespace mlcca::core::cluster::test
