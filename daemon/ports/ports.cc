// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/ports.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <ranges>
#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gates/close_unpinned.hpp"
#include "daemon/gates/entry_slot.hpp"
#include "daemon/gates/interfaces.hpp"
#include "daemon/net/queue.hpp"

namespace mlcca {

/// One slot for each way of a channel through a port; some more are asked for at run time.
std::size_t Ports::ether_slots_of(const core::System& system) {
  return system.channels.size() * GATE_DIRECTIONS + system.publishers.size() * 2;
}

std::vector<Ports::PortState> Ports::ports_of(const core::System& system, std::size_t gateway) {
  std::vector<PortState> ports;
  for (const core::Port& port : system.gateways[gateway].ports) {
    PortState state;
    state.port = port;
    state.network_name = system.networks[port.network].name;
    state.kind = system.networks[port.network].kind;
    state.profile = system.networks[port.network].profile;
    state.described_bitrate = system.networks[port.network].bus.bitrate;
    ports.push_back(std::move(state));
  }
  return ports;
}

void Ports::describe(const core::System& system, std::size_t gateway) {
  std::vector<PortState> next = ports_of(system, gateway);
  for (PortState& state : next) {
    const auto old = std::ranges::find_if(ports_, [&](const PortState& p) {
      return p.port.identity == state.port.identity && p.network_name == state.network_name;
    });
    if (old == ports_.end()) continue;
    state.ifindex = old->ifindex;
    state.can_state = old->can_state;
    state.held = old->held;
    state.unwatched = old->unwatched;
    state.raised = old->raised && old->port.bitrate == state.port.bitrate &&
                   old->port.data_bitrate == state.port.data_bitrate;
  }
  ports_ = std::move(next);
  ether_slots_ = ether_slots_of(system);
}

const net::Link* Ports::link_of(const PortState& port) const {
  const auto it = links_.table().find(port.ifindex);
  return it == links_.table().end() ? nullptr : &it->second;
}

bool Ports::is_to_be_gated(int ifindex) const {
  return std::ranges::any_of(
      ports_, [ifindex](const PortState& p) { return p.ifindex == ifindex && needs_gate(p); });
}

void Ports::follow() {
  forget_vanished();
  const net::FactsOf facts_of = facts_once();
  for (PortState& port : ports_) {
    match(port, facts_of);
    core::Progress::made();
  }
  close_undescribed();
  bool raised = false;
  for (PortState& port : ports_) {
    if (port.ifindex == 0 || !port.problem.empty()) continue;
    if (needs_gate(port)) attach(port);
    if (port.problem.empty() && port.port.managed && !port.raised) raised = raise(port) || raised;
    step_();
  }
  if (raised)
    if (const auto refreshed = links_.refresh(); !refreshed)
      report_({}, refreshed.error().text, true);
  for (PortState& port : ports_) {
    const net::Link* const link = link_of(port);
    port.followed = link != nullptr ? std::optional(*link) : std::nullopt;
    if (link == nullptr) continue;
    if (port.problem.empty()) queue(port);
    port.unsettled = !port.problem.empty();
    judge(port);
    core::Progress::made();
  }
}

void Ports::forget_vanished() {
  vanished_.note(links_.take_gone(), gates_);
  vanished_.let_go(gates_, links_.table(),
                   [this](int ifindex) { return links_.presence(ifindex); });
  if (const auto unpinned = enforce::unpin_vanished(control_); !unpinned)
    report_({}, unpinned.error().text, true);
}

void Ports::close_undescribed() {
  for (const int ifindex : gates_.interfaces()) {
    if (!is_to_be_gated(ifindex)) gates_.find(ifindex)->deny_all();
    core::Progress::made();
  }
  vanished_.forget_all_but(gates_);
  const FormerGates::Present present{
      .links = links_.table(),
      .presence = [this](int ifindex) { return links_.presence(ifindex); },
      .is_gated_port = [this](int ifindex) { return is_to_be_gated(ifindex); },
      .slots = ether_slots_};
  former_.close_pinned(enforce::pinned_interfaces(control_), present, gates_);
  if (former_.may_leave_orphans())
    former_.close_orphans(enforce::gated_interfaces(), present, gates_);
}

Drift::Gates Ports::all_gates() const {
  Drift::Gates all;
  for (const int ifindex : gates_.interfaces())
    all.emplace(ifindex, &gates_.find(ifindex)->port_gate());
  return all;
}

void Ports::check_bypass(int ifindex, std::int64_t now_s) {
  if (HeldGate* const held = gates_.find(ifindex))
    drift_.check_bypass(ifindex, held->port_gate(), links_, now_s);
}

void Ports::match(PortState& port, const net::FactsOf& facts_of) {
  const auto found = net::find_interface(port.port.identity, links_.table(), facts_of);
  port.problem = found ? "" : found.error().text;
  port.unsettled = !found;
  const int now = found && *found ? **found : 0;
  if (now == 0 && port.problem.empty())
    port.problem = fmt::format("the interface ({}) is absent", net::to_text(port.port.identity));
  if (now == port.ifindex) return;
  // Both the interface that was this port and the one that is it now may hold grants of another.
  for (const int ifindex : {port.ifindex, now}) gates_.deny(ifindex);
  if (now != 0)
    report_(port.network_name,
            fmt::format("{} is {} ({})", links_.table().at(now).name, port.network_name,
                        net::to_text(port.port.identity)),
            false);
  else
    report_(port.network_name, fmt::format("{}: {}", port.network_name, port.problem), true);
  port.ifindex = now;
  port.raised = false;
}

void Ports::attach(PortState& port) {
  const net::Link& link = *link_of(port);
  const bool can = port.kind == core::NetworkKind::can;
  if (can && !link.is_can) {
    port.problem = fmt::format("{} is not a CAN interface", link.name);
    return;
  }
  if (!can && !link.is_ethernet) {
    port.problem = fmt::format(
        "{} has no Ethernet frames, and there is a gate for CAN and Ethernet only", link.name);
    return;
  }
  port.unfit = false;
  const auto spec = gate_spec(link, port.kind, port.profile, port.port.refused, ether_slots_);
  if (const auto done = gates_.hold(spec); !done) {
    port.problem = done.error().text;
    if (!gates_.change()) return;  // it goes back to what was
    if (gates_.contains(port.ifindex))
      hold_by_former(port, link.name);
    else
      hold_closed(port, link.name);
    return;
  }
  port.held = 0;
  port.reported.clear();
  port.lost = false;
}

/// The gate of a former description, with nothing that was granted by it.
void Ports::hold_by_former(PortState& port, const std::string& name) {
  port.unfit = true;
  port.lost = false;
  gates_.deny(port.ifindex);
  if (std::exchange(port.reported, port.problem) == port.problem) return;
  report_(port.network_name, port.problem, true);
  report_(port.network_name, name + " is held closed", true);
}

/// The last resort: a gate without pins and slots, which denies everything.
void Ports::hold_closed(PortState& port, const std::string& name) {
  const auto closing = enforce::close_interface(name, root_);
  const bool fresh = closing && *closing == enforce::Closing::closed;
  if (fresh) port.held = port.ifindex;
  // A gate that was there already is an older one that we do not command, unless it is that one.
  port.lost = !closing || (!fresh && port.held != port.ifindex);
  if (std::exchange(port.reported, port.problem) == port.problem) return;
  report_(port.network_name, port.problem, true);
  report_(port.network_name,
          port.lost ? name + " cannot be held: every gate is closed until it can"
                    : name + " is held closed",
          true);
}

bool Ports::out_of_hand() const {
  return former_.unread() || std::ranges::any_of(ports_, &PortState::lost);
}

bool Ports::raise(PortState& port) {
  const net::Link link = *link_of(port);
  const bool set_rates =
      link.kind == "can" && port.port.bitrate != 0 &&
      (link.bitrate != port.port.bitrate ||
       (port.port.data_bitrate != 0 && link.data_bitrate != port.port.data_bitrate));
  Result<void> done;
  if (set_rates) {
    if (link.up) done = links_.set_up(link.ifindex, false);
    if (done) done = links_.set_bitrates(link.ifindex, port.port.bitrate, port.port.data_bitrate);
  }
  if (done && (!link.up || set_rates)) done = links_.set_up(link.ifindex, true);
  if (done) {
    port.raised = true;
    return true;
  }
  port.problem = fmt::format("{}: {}", link.name, done.error().text);
  report_(port.network_name, port.problem, true);
  return false;
}

/// As the analysis assumes it: a queue that another program replaced is put back.
void Ports::queue(PortState& port) {
  if (port.port.queueing != core::Queueing::priority || !is_gated_can(port)) return;
  const std::string& name = link_of(port)->name;
  const auto kept = net::keep_priority_queue(port.ifindex);
  if (!kept)
    port.problem = fmt::format("{}: {}", name, kept.error().text);
  else if (!*kept)
    report_(port.network_name, fmt::format("{} queues by priority, in {} bands", name, GATE_BANDS),
            false);
}

void Ports::set_bands(std::size_t port, std::span<const std::uint32_t> limits) {
  if (enforce::Gate* gate = can_gate_of(port)) gate->set_bands(limits);
}

void Ports::judge(PortState& port) {
  const net::Link* link = link_of(port);
  if (!port.problem.empty() || link == nullptr) return;
  if (!link->up)
    port.problem = link->name + " is down";
  else if (link->can_state == "bus-off")
    port.problem = link->name + " is bus-off";
  else if (is_gated_can(port) && link->bitrate == 0 && link->kind == "can")
    port.problem = "the bit rate of " + link->name + " is unknown";
  else if (is_gated_can(port) && link->bitrate == 0 && port.described_bitrate == 0)
    port.problem = fmt::format("{} has no bit rate of its own: state <Bus bitrate=\"…\"/> of {}",
                               link->name, port.network_name);
  report_can_state(port, *link);
}

/// Error-active is as it should be; bus-off is reported with what it withdraws.
void Ports::report_can_state(PortState& port, const net::Link& link) {
  const bool warns = link.can_state == "error-warning" || link.can_state == "error-passive";
  const std::string now = warns ? link.can_state : "";
  if (std::exchange(port.can_state, now) == now) return;
  report_(port.network_name,
          warns ? fmt::format("{} is {}: frames on {} are being disturbed", link.name, now,
                              port.network_name)
                : fmt::format("{} is {} again", link.name,
                              link.can_state.empty() ? "in order" : link.can_state),
          warns);
}

bool Ports::repair() {
  begin_repair();
  for (auto gate = next_gate(0); gate; gate = next_gate(*gate)) {
    repair(*gate);
    core::Progress::made();
  }
  return wants_gate();
}

void Ports::begin_repair() {
  for (const auto& link : links_.take_moved()) drift_.report_moved(link);
  drift_.forget_all_but(all_gates());
}

bool Ports::repair(int ifindex) {
  HeldGate* const held = gates_.find(ifindex);
  if (held == nullptr) return true;
  const bool kept = drift_.repair(ifindex, held->port_gate(), links_.table());
  if (!kept) gates_.forget(ifindex);
  for (PortState& port : ports_)
    if (port.ifindex == ifindex && port.problem.empty() && link_of(port) != nullptr) queue(port);
  return kept;
}

bool Ports::wants_gate() const {
  return std::ranges::any_of(ports_, [this](const PortState& p) {
    if (p.port.queueing == core::Queueing::priority && !p.problem.empty() && p.ifindex != 0)
      return true;
    const net::Link* link = link_of(p);
    return link != nullptr && can_have_gate(p, *link) && (p.unfit || !gates_.contains(p.ifindex));
  });
}

std::vector<core::Condition> Ports::conditions(std::size_t networks) const {
  std::vector<core::Condition> out(networks);
  for (const PortState& port : ports_) {
    core::Condition& c = out[port.port.network];
    c.available = port.problem.empty();
    c.problem = port.problem;
    if (const net::Link* link = link_of(port); link != nullptr && link->kind == "can")
      c.timing = {link->bitrate, link->data_bitrate};
  }
  return out;
}

std::optional<BusCounters> Ports::bus_counters(std::size_t port) {
  const net::Link* link = link_of(ports_[port]);
  if (link == nullptr || !link->is_can || !link->up) return std::nullopt;
  const auto traffic = links_.traffic(link->ifindex);
  if (!traffic) return std::nullopt;
  // A virtual bus counts what it loops back as received, too.
  if (link->kind == "vcan") return BusCounters{traffic->sent_frames, traffic->sent_bytes};
  return BusCounters{traffic->sent_frames + traffic->received_frames,
                     traffic->sent_bytes + traffic->received_bytes};
}

static_assert(core::kMostEntries == GATE_CHAIN);

std::optional<std::uint32_t> Ports::source_of(const core::GateEntry& e) const {
  if (!e.source_port) return 0;
  const int ifindex = ports_[*e.source_port].ifindex;
  if (ifindex == 0) return std::nullopt;  // nothing can come from there
  return static_cast<std::uint32_t>(ifindex);
}

std::optional<enforce::SlotSpec> Ports::slot_of(const core::GateEntry& e) const {
  const auto source = source_of(e);
  if (!source) return std::nullopt;
  return enforce::slot_of(e, ports_[e.port].kind, *source);
}

std::optional<enforce::SlotSpec> Ports::slot_of(const core::GateRule& rule) const {
  const auto source = source_of(rule.entry);
  if (!source) return std::nullopt;
  return enforce::slot_of(rule, ports_[rule.entry.port].kind, *source);
}

Result<void> Ports::sync(const core::GateState& wanted) {
  std::vector<std::vector<enforce::SlotSpec>> slots(ports_.size());
  for (const core::GateRule& rule : wanted) {
    if (gate_of(rule.entry.port) != nullptr)
      if (auto slot = slot_of(rule)) slots[rule.entry.port].push_back(*slot);
    core::Progress::step();
  }
  std::vector<enforce::PortGate::Change> changes;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    enforce::PortGate* const gate = gate_of(p);
    if (gate == nullptr) continue;
    if (auto change = enforce::difference(gate->present(), slots[p]); !change.empty())
      changes.push_back({gate, std::move(change)});
    core::Progress::made();
  }
  std::string problems;
  for (;;) {
    const auto done = enforce::PortGate::apply_together(changes);
    if (done) break;
    enforce::PortGate* const refusing = done.error().gate;
    refusing->deny_all();
    problems += (problems.empty() ? "" : "; ") + refusing->name() + ": " + done.error().error.text;
    std::erase_if(changes, [&](const auto& c) { return c.gate == refusing; });
  }
  report_unwatched();
  if (!problems.empty()) return fail(problems);
  return {};
}

std::map<std::size_t, enforce::SlotChanges> Ports::by_port(const core::GateChanges& changes) const {
  std::map<std::size_t, enforce::SlotChanges> out;
  const auto spread = [&](const std::vector<core::GateEntry>& entries,
                          std::vector<enforce::SlotSpec> enforce::SlotChanges::* list) {
    for (const core::GateEntry& e : entries) {
      if (gate_of(e.port) != nullptr)
        if (auto slot = slot_of(e)) (out[e.port].*list).push_back(*slot);
      core::Progress::step();
    }
  };
  spread(changes.close, &enforce::SlotChanges::close);
  spread(changes.remove, &enforce::SlotChanges::remove);
  spread(changes.open, &enforce::SlotChanges::open);
  const auto spread_rules = [&](const core::GateState& rules,
                                std::vector<enforce::SlotSpec> enforce::SlotChanges::* list) {
    for (const core::GateRule& rule : rules) {
      if (gate_of(rule.entry.port) != nullptr)
        if (auto slot = slot_of(rule)) (out[rule.entry.port].*list).push_back(*slot);
      core::Progress::step();
    }
  };
  spread_rules(changes.add, &enforce::SlotChanges::add);
  spread_rules(changes.police, &enforce::SlotChanges::police);
  return out;
}

Result<void> Ports::apply(const core::GateChanges& changes) {
  std::vector<enforce::PortGate::Change> gates;
  for (auto& [p, change] : by_port(changes)) gates.push_back({gate_of(p), std::move(change)});
  if (const auto done = enforce::PortGate::apply_together(gates); !done)
    return fail(done.error().gate->name() + ": " + done.error().error.text);
  report_unwatched();
  return {};
}

Frames Ports::frames(const core::GateState& rules,
                     const std::vector<core::GateEntry>& shared) const {
  const auto any = [&rules](core::Direction direction, auto&& is_meant) {
    return std::ranges::any_of(rules, [&](const core::GateRule& r) {
      return r.entry.direction == direction && is_meant(r.entry);
    });
  };
  const auto is_own = [&shared](const core::GateEntry& entry) {
    return !std::ranges::binary_search(shared, entry);
  };
  const bool leaves = any(core::Direction::egress, [](const auto&) { return true; });
  const bool counted_out =
      leaves && (any(core::Direction::egress, is_own) || !any(core::Direction::ingress, is_own));
  const auto counts = counted_out ? core::Direction::egress : core::Direction::ingress;
  Frames sum;
  for (const core::GateRule& rule : rules) {
    const enforce::PortGate* gate = gate_of(rule.entry.port);
    if (gate == nullptr) continue;
    const auto slot = slot_of(rule.entry);
    const auto counted = slot ? gate->counters(*slot) : std::nullopt;
    if (!counted) continue;
    sum.dropped += counted->dropped;
    sum.would_drop += counted->would_drop;
    sum.would_exceed += counted->would_exceed;
    sum.excess += counted->excess + counted->would_exceed;
    if (!rule.policing.counts_only) sum.excess_dropped += counted->excess;
    if (rule.entry.direction == counts) sum.passed += counted->passed;
    if (counted->last_reason != GATE_R_PASSED)
      sum.last_reason = enforce::reason_text(counted->last_reason);
  }
  return sum;
}

}  // namespace mlcca
