// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/ports.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "core/model/progress.hpp"
#include "core/profiles/profile.hpp"
#include "daemon/gates/close_unpinned.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/ports/kernel_gate.hpp"

namespace mlcca {

Ports::Ports(net::Links& links, gates::Control& control, net::FactsOf facts_of, ReportLine report,
             Drift::Report report_drift)
    : links_(links),
      control_(control),
      facts_of_(std::move(facts_of)),
      report_(std::move(report)),
      ports_([&control](const GateSpec& spec) { return KernelGate::load(spec, control); },
             [&control](const std::string& interface) {
               return gates::close_interface(interface, control);
             }),
      former_(report_),
      drift_(std::move(report_drift)) {}

Result<void> Ports::prepare(const core::System& system, std::size_t gateway) {
  return ports_.prepare(system, gateway, links_.table(), net::read_once(facts_of_), step_);
}

bool Ports::needs_reconcile() {
  vanished_.note(links_.take_gone(), ports_.gates());
  if (needs_recheck() || out_of_hand()) return true;
  const bool lacks_interface =
      std::ranges::any_of(ports_.gates().interfaces(),
                          [this](int ifindex) { return !links_.table().contains(ifindex); });
  return lacks_interface || ports_.is_any_outdated(links_.table(), net::read_once(facts_of_));
}

/// The order is: bit rate, gate, up. Everything that has a new owner is denied before anything
/// else.
Result<void> Ports::follow() {
  forget_vanished();
  match();
  close_undescribed();
  auto attached = attach();
  assess();
  return attached;
}

void Ports::forget_vanished() {
  vanished_.note(links_.take_gone(), ports_.gates());
  vanished_.let_go(ports_.gates(), links_.table(),
                   [this](int ifindex) { return presence(ifindex); });
  if (const auto unpinned = gates::unpin_vanished(control_); !unpinned)
    report_({}, unpinned.error().text, true);
}

void Ports::match() {
  const net::FactsOf facts_of = net::read_once(facts_of_);
  for (GatedPort& gated : ports_) {
    DescribedPort& port = gated.port;
    if (const auto former = port.match(links_.table(), facts_of)) {
      // Both the former interface of this port and the present one may hold grants of another port.
      for (const int ifindex : {*former, port.ifindex()}) ports_.gates().deny(ifindex);
      port.report_match(links_.table(), report_);
    }
    core::Progress::made();
  }
}

void Ports::close_undescribed() {
  GateSet& gates = ports_.gates();
  for (const int ifindex : gates.interfaces()) {
    if (!ports_.is_to_be_gated(ifindex)) gates.find(ifindex)->deny_all();
    core::Progress::made();
  }
  vanished_.forget_all_but(gates);
  const FormerGates::Present present{
      .links = links_.table(),
      .presence = [this](int ifindex) { return presence(ifindex); },
      .is_gated_port = [this](int ifindex) { return ports_.is_to_be_gated(ifindex); },
      .slots = ports_.ether_slots()};
  former_.close_pinned(gates::pinned_interfaces(control_), present, gates);
  if (former_.may_leave_orphans()) former_.close_orphans(gates::gated_interfaces(), present, gates);
  report_undescribed();
}

void Ports::report_undescribed() {
  auto now = closed();
  for (const std::string& name : now)
    if (std::ranges::find(reported_undescribed_, name) == reported_undescribed_.end())
      report_({}, undescribed_line(name), true);
  reported_undescribed_ = std::move(now);
}

/// Without the interfaces of ports without a profile, for which the port reports the problem.
std::vector<std::string> Ports::undescribed() const {
  auto names = closed();
  for (std::size_t p = 0; p < ports_.size(); ++p)
    if (ports_.closed_gate(p) != nullptr)
      std::erase(names, ports_[p].interface_name(links_.table()));
  return names;
}

std::vector<std::string> Ports::closed() const {
  std::vector<std::string> names;
  for (const int ifindex : ports_.gates().interfaces()) {
    if (ports_.is_to_be_gated(ifindex)) continue;
    const auto link = links_.table().find(ifindex);
    if (link != links_.table().end()) names.push_back(link->second.name);
  }
  return names;
}

/// The error is that of follow().
Result<void> Ports::attach() {
  Result<void> attached;
  bool raised = false;
  for (GatedPort& gated : ports_) {
    DescribedPort& port = gated.port;
    if (port.ifindex() == 0 || !port.problem().empty()) continue;
    if (port.needs_gate())
      if (auto done = ports_.attach(gated, *port.link(links_.table()), report_); !done)
        attached = std::move(done);
    if (port.problem().empty() && port.is_to_be_raised())
      raised = port.raise(links_, report_) || raised;
    step_();
  }
  if (raised)
    if (const auto refreshed = links_.refresh(); !refreshed)
      report_({}, refreshed.error().text, true);
  return attached;
}

void Ports::assess() {
  std::size_t p = 0;
  for (GatedPort& gated : ports_) {
    gated.port.assess(links_.table(), report_);
    const DescribedPort& port = gated.port;
    if (ports_.closed_gate(p++) != nullptr && port.problem().empty())
      gated.port.set_problem(fmt::format(
          "{} has no profile, and {} has a gate, which stays closed: state a Profile, or take the "
          "gate off",
          port.network(), port.interface_name(links_.table())));
    core::Progress::made();
  }
}

bool Ports::repair() {
  begin_repair();
  for (const int ifindex : ports_.gates().interfaces()) {
    repair(ifindex);
    core::Progress::made();
  }
  return wants_gate();
}

void Ports::begin_repair() {
  for (const auto& link : links_.take_moved()) drift_.report_moved(link);
  drift_.forget_all_but(ports_.gates().interfaces());
}

bool Ports::repair(int ifindex) {
  HeldGate* const held = ports_.gates().find(ifindex);
  if (held == nullptr) return true;
  if (give_up(ifindex, held->port_gate()))
    // A port without a profile can be used from now on.
    return std::ranges::none_of(
        ports_, [ifindex](const GatedPort& gated) { return gated.port.ifindex() == ifindex; });
  const bool kept = drift_.repair(ifindex, held->port_gate(), links_.table());
  if (!kept) ports_.gates().forget(ifindex);
  for (GatedPort& gated : ports_)
    if (gated.port.ifindex() == ifindex) gated.port.keep_queue(links_.table(), report_);
  return kept;
}

/// A person takes the gate off an undescribed interface by removing its programs in both
/// directions. If one is left, or if that is unknown, the gate is repaired like any other.
bool Ports::give_up(int ifindex, gates::PortGate& gate) {
  if (ports_.is_to_be_gated(ifindex) || !gate.is_taken_off().value_or(false)) return false;
  drift_.report_taken_off(gate);
  gate.give_up();
  ports_.gates().forget(ifindex);
  return true;
}

void Ports::check_bypass(int ifindex, std::int64_t now_s) {
  if (HeldGate* const held = ports_.gates().find(ifindex))
    drift_.check_bypass(ifindex, held->port_gate(), links_, now_s);
}

Result<void> Ports::sync(const core::GateState& wanted) {
  auto done = hold_exactly(wanted, ports_);
  report_unwatched(ports_, links_.table(), report_);
  return done;
}

Result<void> Ports::apply(const core::GateChanges& changes) {
  auto done = make_changes(changes, ports_);
  if (done) report_unwatched(ports_, links_.table(), report_);
  return done;
}

void Ports::set_bands(std::size_t port, std::span<const std::uint32_t> limits) {
  if (gates::Gate* gate = ports_.can_gate(port)) gate->set_bands(limits);
}

std::vector<core::Condition> Ports::conditions(std::size_t networks) const {
  std::vector<core::Condition> out(networks);
  for (std::size_t p = 0; p < ports_.size(); ++p)
    ports_[p].state_in(out[ports_[p].described().network], links_.table());
  return out;
}

std::optional<BusCounters> Ports::bus_counters(std::size_t port) {
  const net::Link* link = ports_[port].link(links_.table());
  if (link == nullptr || !link->is_can || !link->up) return std::nullopt;
  const auto traffic = links_.traffic(link->ifindex);
  if (!traffic) return std::nullopt;
  // A virtual bus also counts what it loops back as received.
  if (link->kind == "vcan") return BusCounters{traffic->sent_frames, traffic->sent_bytes};
  return BusCounters{traffic->sent_frames + traffic->received_frames,
                     traffic->sent_bytes + traffic->received_bytes};
}

std::optional<gates::Bindings> Ports::bindings(std::size_t port) const {
  const gates::Gate* gate = ports_.can_gate(port);
  if (gate == nullptr || !core::traits_of(ports_[port].profile()).deals_tags) return std::nullopt;
  return gate->bindings();
}

}  // namespace mlcca
