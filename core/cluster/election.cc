// SPDX-License-Identifier: BSD-2-Clause
#include "core/cluster/election.hpp"

namespace mlcca::core::cluster {

/// Whether all gateways beside this one that carry something, or are about to, have acted on this
/// gateway's request to take over again.
bool Election::all_know(const View& view, Value now) const {
  for (std::size_t g = 0; g < failed_.size(); ++g) {
    if (!view.keys().side_by_side(self_, g)) continue;
    const Alive alive = view.alive(g, now);
    if (alive != Alive::present && alive != Alive::silent) continue;
    if (!view.surely_closed(g, taking_since_, now)) return false;
  }
  return true;
}

Role Election::wanted(const View& view, Value now, bool draining) const {
  if (!able_ || draining) return Role::standby;
  if (role_ != Role::taking) return role_ == Role::active ? Role::active : Role::taking;
  // The view must be as new as the request; otherwise it may lack gateways that came before it.
  return view.revision() >= taking_since_ && all_know(view, now) ? Role::active : Role::taking;
}

void Election::on_committed(Role role, std::int64_t revision) {
  if (role == Role::taking && role_ != Role::taking) taking_since_ = revision;
  role_ = role;
}

void Election::step(const View& view, Value now, bool joined, std::vector<Event>& events) {
  if (!view.complete()) return;
  for (std::size_t g = 0; g < failed_.size(); ++g) {
    const Alive alive = view.alive(g, now);
    const bool failed = g == self_ ? !joined || role_ != Role::active
                                   : alive != Alive::present && alive != Alive::silent;
    if (failed == failed_[g]) continue;
    failed_[g] = failed;
    events.emplace_back(Failed{.gateway = g, .failed = failed});
  }
}

}  // namespace mlcca::core::cluster
