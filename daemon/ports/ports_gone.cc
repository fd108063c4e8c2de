// SPDX-License-Identifier: BSD-2-Clause
// Gates whose interface has gone, or is not described any more.
#include <fmt/core.h>

#include "core/model/progress.hpp"
#include "daemon/gates/close_unpinned.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/ports/ports.hpp"

namespace mlcca {

/// The kernel has reported that the interface of a gate went, or answers so when it is asked for
/// this one. That a list lacks it proves nothing.
bool Ports::has_gone(int ifindex) {
  const bool listed = links_.table().contains(ifindex);
  if (listed && !unconfirmed_.contains(ifindex)) return false;
  switch (links_.presence(ifindex)) {
    case net::Presence::gone:
      unconfirmed_.erase(ifindex);
      gates_.find(ifindex)->unpin();
      return true;
    case net::Presence::there:
      // It went, and another one has its number, or it is back: a gate of its own finds out what
      // is attached there. Until it is listed the one that is there stays.
      if (listed) return unconfirmed_.erase(ifindex) != 0;
      break;
    case net::Presence::unknown:
      break;
  }
  unconfirmed_.insert(ifindex);
  return false;
}

void Ports::mark_unconfirmed() {
  for (const int gone : links_.take_gone())
    if (gates_.contains(gone)) unconfirmed_.insert(gone);
}

void Ports::forget_vanished() {
  mark_unconfirmed();
  for (const int ifindex : gates_.interfaces())
    if (has_gone(ifindex)) gates_.forget(ifindex);
  if (const auto unpinned = enforce::unpin_vanished(control_); !unpinned)
    report_({}, unpinned.error().text, true);
}

void Ports::close_undescribed() {
  for (const int ifindex : gates_.interfaces()) {
    if (!is_to_be_gated(ifindex)) gates_.find(ifindex)->deny_all();
    core::Progress::made();
  }
  std::erase_if(unconfirmed_, [this](int ifindex) { return !gates_.contains(ifindex); });
  const auto pinned = enforce::pinned_interfaces(control_);
  if (unread_.is_new(pinned ? "" : pinned.error().text))
    report_({},
            unread_.text() + ": it is unknown which gates a former daemon left, and all are closed",
            true);
  if (!pinned) return;
  for (const std::uint32_t number : *pinned) {
    const auto ifindex = static_cast<int>(number);
    core::Progress::made();
    if (is_to_be_gated(ifindex) || gates_.contains(ifindex)) continue;
    const auto link = links_.table().find(ifindex);
    if (link == links_.table().end()) {
      if (links_.presence(ifindex) != net::Presence::gone) unconfirmed_.insert(ifindex);
      continue;
    }
    close(link->second);
  }
}

void Ports::close(const net::Link& link) {
  const auto held = gates_.hold(closed_gate_spec(link, ether_slots_));
  if (!held) {
    report_({}, held.error().text, true);
    return;
  }
  gates_.find(link.ifindex)->deny_all();
  report_(
      {},
      fmt::format("{} is not described, or without a profile: its gate stays closed", link.name),
      true);
}

/// Once: gates that no pin names, because another program removed the pins of a former daemon.
/// Where the interface is described, its own gate takes their place.
void Ports::close_orphans() {
  if (orphans_closed_) return;
  const auto found = enforce::gated_interfaces();
  orphans_closed_ = found.has_value();
  if (orphans_unknown_.is_new(found ? "" : found.error().text))
    report_(
        {},
        orphans_unknown_.text() + ": it is unknown which gates without pins a former daemon left",
        true);
  if (!found) return;
  for (const enforce::GatedInterface& gated : *found) {
    const auto ifindex = static_cast<int>(gated.ifindex);
    const auto link = links_.table().find(ifindex);
    if (!gated.passes || is_to_be_gated(ifindex) || gates_.contains(ifindex) ||
        link == links_.table().end())
      continue;
    close(link->second);
    core::Progress::made();
  }
}

}  // namespace mlcca
