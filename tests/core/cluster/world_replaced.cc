// SPDX-License-Identifier: BSD-2-Clause
// Reservations that are replaced by smaller ones for the same traffic, as the daemon replaces them
// when one of several admissions has ended.
#include <algorithm>

#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

bool World::may_replace(std::size_t g) const {
  const Host& host = hosts_[g];
  return replaces_ > 0 && !scenario_->behalf && !host.held.empty() && host.replaces.empty() &&
         host.member->why_not(clock(g)).empty();
}

void World::replace(std::size_t g) {
  --replaces_;
  Host& host = hosts_[g];
  const std::uint64_t former = *host.held.begin();
  const std::uint64_t id = host.next_id++;
  host.replaces.emplace(id, former);
  continued_.emplace(Admission(g, former), Admission(g, id));
  ask(g, id, way_of(g));
  if (scenario_->mutant != Mutant::given_back_first) return;
  close(g, {g, former});
  host.member->release(former, clock(g));
}

/// What it replaces has ended meanwhile: nobody needs it.
bool World::is_replaced_in_vain(std::size_t g, std::uint64_t id) {
  Host& host = hosts_[g];
  const auto it = host.replaces.find(id);
  if (it == host.replaces.end() || host.held.contains(it->second)) return false;
  host.replaces.erase(it);
  return true;
}

/// What was to replace another one is refused.
void World::keep_replaced(std::size_t g, std::uint64_t id) {
  const auto former = hosts_[g].replaces.extract(id);
  if (former) continued_.erase({g, former.mapped()});
}

/// The former one is given back when the one in its place is open.
void World::end_replaced(std::size_t g, std::uint64_t id) {
  Host& host = hosts_[g];
  const auto it = host.replaces.find(id);
  if (it == host.replaces.end()) return;
  const std::uint64_t former = it->second;
  host.replaces.erase(it);
  host.held.erase(former);
  close(g, {g, former});
  host.member->release(former, clock(g));
}

/// Without faults, a gateway on the way has the one in its place open when the former one ends.
void World::check_replaced(std::size_t g, const Origin& ended) {
  const auto it = continued_.find({ended.gateway, ended.id});
  const Scenario& s = *scenario_;
  if (it == continued_.end() || s.crashes + s.pauses + s.fences + s.refusals + s.drains != 0)
    return;
  const auto gate = hosts_[g].gates.find(it->second);
  if (gate == hosts_[g].gates.end() || !gate->second.open)
    broken_ = "what continues was interrupted at another gateway";
}

}  // namespace mlcca::core::cluster::test
