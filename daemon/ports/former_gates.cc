// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/former_gates.hpp"

#include "core/model/progress.hpp"

namespace mlcca {

void FormerGates::close_pinned(const Result<std::vector<std::uint32_t>>& pinned,
                               const Present& present, GateSet& gates) {
  unlisted_ = false;
  if (unread_.is_new(pinned ? "" : pinned.error().text))
    report_({},
            unread_.text() + ": it is unknown which gates a former daemon left, and all are closed",
            true);
  if (!pinned) return;
  for (const std::uint32_t number : *pinned) {
    const auto ifindex = static_cast<int>(number);
    core::Progress::made();
    if (present.is_gated_port(ifindex) || gates.contains(ifindex)) continue;
    const auto link = present.links.find(ifindex);
    if (link != present.links.end())
      close(link->second, present.slots, gates);
    else if (present.presence(ifindex) != net::Presence::gone)
      unlisted_ = true;
  }
}

void FormerGates::close_orphans(const Result<std::vector<gates::GatedInterface>>& found,
                                const Present& present, GateSet& gates) {
  orphans_closed_ = found.has_value();
  if (orphans_unknown_.is_new(found ? "" : found.error().text))
    report_(
        {},
        orphans_unknown_.text() + ": it is unknown which gates without pins a former daemon left",
        true);
  if (!found) return;
  for (const gates::GatedInterface& gated : *found) {
    const auto ifindex = static_cast<int>(gated.ifindex);
    const auto link = present.links.find(ifindex);
    if (!gated.passes || present.is_gated_port(ifindex) || gates.contains(ifindex) ||
        link == present.links.end())
      continue;
    close(link->second, present.slots, gates);
    core::Progress::made();
  }
}

void FormerGates::close(const net::Link& link, std::size_t slots, GateSet& gates) {
  const auto held = gates.hold(closed_gate_spec(link, slots));
  if (!held) {
    report_({}, held.error().text, true);
    return;
  }
  gates.find(link.ifindex)->deny_all();
}

}  // namespace mlcca
