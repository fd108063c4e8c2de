// SPDX-License-Identifier: BSD-2-Clause
// How a gateway leaves its cluster, at the end of the daemon or while an operator wants it, and the
// texts about that.
#include <fmt/format.h>

#include "core/cluster/strange.hpp"
#include "daemon/gateway/membership.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

constexpr Value kLeaveLimit = 5'000'000'000;  // ns

}  // namespace

void Membership::leave() {
  if (!member_) return;
  leave_until_ = add_saturating(now(), kLeaveLimit);
  if (!leaving_) begin_leaving();
}

void Membership::begin_leaving() {
  leaving_ = true;
  reserving_->refuse_all("this gateway is being drained");
  static_cast<void>(bring_in_line());
  drain_when_closed();
}

void Membership::drain_when_closed() {
  if (!leaving_ || draining_ || !parts_.turn.in_line()) return;
  draining_ = true;
  reserving_->lost();
  member_->drain(now());
}

bool Membership::may_end() const {
  return !member_ || left_ || !store_.reachable || now() >= leave_until_;
}

/// Commits what waits to be written first, so that a failure of this entry does not revert it.
Result<void> Membership::write_drained(bool drained) {
  parts_.before_commit();
  parts_.turn.commit();
  store::Membership after = record();
  after.drained = drained;
  if (auto done = parts_.recorder.write_at_once({store::Entry(after)}); !done) return done;
  drained_ = drained;
  until_restart_ = false;
  return {};
}

Result<void> Membership::drain(bool until_restart) {
  if (until_restart)
    drained_ = until_restart_ = true;
  else if (auto written = write_drained(true); !written)
    return written;
  if (!leaving_) begin_leaving();
  return {};
}

/// Does what a start does: what the store still has of this gateway stays reserved, the rest is
/// requested again.
Result<void> Membership::join() {
  if (auto written = write_drained(false); !written) return written;
  leaving_ = false;
  adopting_->lost();
  state().set_permits(nullptr);
  begin();
  static_cast<void>(parts_.turn.settle(take_up_state(true)));
  return {};
}

std::string Membership::leaving_words() const {
  if (drained_ && left_ && !until_restart_)
    return "this gateway is drained: 'mlccactl cluster join' ends that";
  if (drained_ && left_) return "this gateway is drained until mlccad is started again";
  return store_.reachable ? "this gateway is being drained"
                          : "this gateway is being drained, and the store does not answer";
}

std::string Membership::closed_words() const {
  if (permits().is_open()) return "nothing new is granted on networks of several gateways";
  return permits().standing_is_open() ? "what is reserved on networks of several gateways is closed"
                                      : "networks of several gateways are closed";
}

/// Problems of the store, which other gateways have as well.
void Membership::add_troubles(std::vector<std::string>& to) const {
  if (store_.no_space)
    to.push_back(fmt::format("cluster {}: the store is full, it takes nothing new", system_));
  const auto& records = member_->view().records();
  if (const auto words = cc::too_many_words(records, *keys_); !words.empty()) {
    to.push_back(
        fmt::format("cluster {}: the store has too many entries: nothing more is granted "
                    "on networks of several gateways: {}",
                    system_, words));
    return;
  }
  const core::State& now = state();
  for (std::size_t n = 0; n < keys_->networks(); ++n) {
    if (const auto words = cc::unreadable_words(records, *keys_, n); !words.empty())
      to.push_back(
          fmt::format("cluster {}: what the store has of {} cannot be read: nothing more "
                      "is granted there: {}",
                      system_, now.system().networks[n].name, words));
    if (const auto words = now.held_by_others().excess(n); !words.empty())
      to.push_back(fmt::format("cluster {}: {}", system_, words));
  }
  if (const auto words = cc::unreadable_words(records, *keys_); !words.empty())
    to.push_back(
        fmt::format("cluster {}: an entry of the store cannot be read: {}", system_, words));
}

core::cluster::Foreign Membership::of_others(std::size_t network) const {
  return member_ && networks_ ? networks_->of_others(network, member_->view()) : cc::Foreign{};
}

std::map<std::size_t, core::MadeFor> Membership::made_for(std::size_t network) const {
  return member_ ? member_->view().made_for(network) : std::map<std::size_t, core::MadeFor>{};
}

std::string Membership::unreadable(std::size_t network) const {
  return member_ ? cc::unreadable_words(member_->view().records(), *keys_, network) : std::string();
}

}  // namespace mlcca
