// SPDX-License-Identifier: BSD-2-Clause
// Which changes of interfaces concern the ports: other interfaces come and go all the time where
// containers do.
#include <algorithm>

#include "daemon/ports/ports.hpp"

namespace mlcca {

/// The identity of the port decides, not the content of a notification: so nothing is missed where
/// some were lost.
bool Ports::concerns(const PortState& port, const net::FactsOf& facts_of) const {
  if (port.unsettled) return true;
  const net::Link* const link = link_of(port);
  if (link == nullptr ? port.ifindex != 0 || port.followed.has_value() : port.followed != *link)
    return true;
  const auto found = net::find_interface(port.port.identity, links_.table(), facts_of);
  return !found || found->value_or(0) != port.ifindex;
}

bool Ports::needs_reconcile() {
  vanished_.note(links_.take_gone(), gates_);
  if (needs_recheck() || out_of_hand()) return true;
  const bool lacks_interface = std::ranges::any_of(
      gates_.interfaces(), [this](int ifindex) { return !links_.table().contains(ifindex); });
  if (lacks_interface) return true;
  const net::FactsOf facts_of = facts_once();
  return std::ranges::any_of(ports_,
                             [&](const PortState& port) { return concerns(port, facts_of); });
}

}  // namespace mlcca
