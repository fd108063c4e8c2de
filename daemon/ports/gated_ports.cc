// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/gated_ports.hpp"

#include <algorithm>
#include <utility>

#include "bpf/gate.h"

namespace mlcca {
namespace {

/// One slot for each channel and direction, and some more for run-time admissions.
std::size_t ether_slots_of(const core::System& system) {
  return system.channels.size() * GATE_DIRECTIONS + system.publishers.size() * 2;
}

GateSpec spec_of(const DescribedPort& port, const net::Link& link, std::size_t ether_slots) {
  return gate_spec(link, port.kind(), port.profile(), port.described().refused, ether_slots);
}

}  // namespace

void GatedPorts::describe(const core::System& system, std::size_t gateway) {
  std::vector<GatedPort> next;
  for (DescribedPort& port : ports_of(system, gateway)) {
    GatedPort& gated = next.emplace_back(GatedPort{std::move(port), {}});
    const auto former = std::ranges::find_if(
        ports_, [&](const GatedPort& p) { return gated.port.is_same(p.port); });
    if (former == ports_.end()) continue;
    gated.port.take_over(former->port);
    gated.hold.take_over(former->hold);
    gated.unwatched = former->unwatched;
  }
  ports_ = std::move(next);
  ether_slots_ = ether_slots_of(system);
}

Result<void> GatedPorts::prepare(const core::System& system, std::size_t gateway,
                                 const net::InterfaceTable& links, const net::FactsOf& facts_of,
                                 const std::function<void()>& step) {
  for (DescribedPort& port : ports_of(system, gateway)) {
    static_cast<void>(port.match(links, facts_of));
    const net::Link* const link = port.link(links);
    if (link == nullptr || !port.can_have_gate(*link)) continue;
    // A port that lacks its gate already does not get worse by a failure.
    const bool is_lacking = is_to_be_gated(link->ifindex) && !gates_.contains(link->ifindex);
    auto made = gates_.make_spare(spec_of(port, *link, ether_slots_of(system)));
    if (!made && !is_lacking) {
      gates_.end_change();
      return made;
    }
    step();
  }
  gates_.begin_change();
  return {};
}

Result<void> GatedPorts::attach(GatedPort& gated, const net::Link& link, const ReportLine& report) {
  DescribedPort& port = gated.port;
  if (!port.can_have_gate(link)) {
    port.set_problem(port.lacks_framing(link));
    return {};
  }
  auto done =
      gated.hold.attach(link, spec_of(port, link, ether_slots_), gates_, close_,
                        [&](const std::string& line) { report(port.network(), line, true); });
  if (!done) port.set_problem(done.error().text);
  return gates_.must_go_back() ? done : Result<void>();
}

HeldGate* GatedPorts::held(std::size_t port) const {
  const GatedPort& gated = ports_[port];
  return gated.port.needs_gate() && !gated.hold.is_by_former() ? gates_.find(gated.port.ifindex())
                                                               : nullptr;
}

gates::PortGate* GatedPorts::gate(std::size_t port) const {
  HeldGate* const gate = held(port);
  return gate == nullptr ? nullptr : &gate->port_gate();
}

gates::PortGate* GatedPorts::closed_gate(std::size_t port) const {
  const int ifindex = ports_[port].port.ifindex();
  if (ifindex == 0 || is_to_be_gated(ifindex)) return nullptr;
  HeldGate* const gate = gates_.find(ifindex);
  return gate == nullptr ? nullptr : &gate->port_gate();
}

gates::Gate* GatedPorts::can_gate(std::size_t port) const {
  HeldGate* const gate = held(port);
  return gate == nullptr ? nullptr : gate->can_gate();
}

bool GatedPorts::is_to_be_gated(int ifindex) const {
  return std::ranges::any_of(ports_, [ifindex](const GatedPort& p) {
    return p.port.ifindex() == ifindex && p.port.needs_gate();
  });
}

bool GatedPorts::wants_gate(const net::InterfaceTable& links) const {
  return std::ranges::any_of(ports_, [&](const GatedPort& p) {
    if (p.port.lacks_queue()) return true;
    const net::Link* const link = p.port.link(links);
    return link != nullptr && p.port.can_have_gate(*link) &&
           (p.hold.is_by_former() || !gates_.contains(link->ifindex));
  });
}

bool GatedPorts::is_any_lost() const {
  return std::ranges::any_of(ports_, [](const GatedPort& p) { return p.hold.is_lost(); });
}

bool GatedPorts::is_any_outdated(const net::InterfaceTable& links,
                                 const net::FactsOf& facts_of) const {
  return std::ranges::any_of(
      ports_, [&](const GatedPort& p) { return p.port.is_outdated(links, facts_of); });
}

}  // namespace mlcca
