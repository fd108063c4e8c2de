// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/vanished_gates.hpp"

namespace mlcca {

void VanishedGates::note(const std::set<int>& gone, const GateSet& gates) {
  for (const int ifindex : gone)
    if (gates.contains(ifindex)) unconfirmed_.insert(ifindex);
}

void VanishedGates::let_go(GateSet& gates, const net::InterfaceTable& links,
                           const Presence& presence) {
  for (const int ifindex : gates.interfaces()) {
    const Fate fate = fate_of(ifindex, links, presence);
    if (fate == Fate::stays) continue;
    if (fate == Fate::gone) gates.find(ifindex)->unpin();
    gates.forget(ifindex);
  }
}

VanishedGates::Fate VanishedGates::fate_of(int ifindex, const net::InterfaceTable& links,
                                           const Presence& presence) {
  const bool listed = links.contains(ifindex);
  if (listed && !unconfirmed_.contains(ifindex)) return Fate::stays;
  switch (presence(ifindex)) {
    case net::Presence::gone:
      unconfirmed_.erase(ifindex);
      return Fate::gone;
    case net::Presence::there:
      if (!listed) break;
      unconfirmed_.erase(ifindex);
      return Fate::replaced;
    case net::Presence::unknown:
      break;
  }
  unconfirmed_.insert(ifindex);
  return Fate::stays;
}

void VanishedGates::forget_all_but(const GateSet& gates) {
  std::erase_if(unconfirmed_, [&](int ifindex) { return !gates.contains(ifindex); });
}

}  // namespace mlcca
