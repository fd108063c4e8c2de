// SPDX-License-Identifier: BSD-2-Clause
#include "tests/daemon/gateway/fakes.hpp"

#include <algorithm>

#include "daemon/gates/entry_slot.hpp"

namespace mlcca::test {

// --- the kernel ----------------------------------------------------------------------------------

void Calls::refuse(std::size_t at, std::size_t many) {
  first_ = count_ + at;
  many_ = many;
  kills_ = false;
}

void Calls::kill(std::size_t at) {
  first_ = count_ + at;
  many_ = 1;
  kills_ = true;
}

Result<void> Calls::make(const std::string& what) {
  ++count_;
  if (many_ == 0 || count_ < first_ || count_ - first_ >= many_) return {};
  if (kills_) throw Killed{};
  return fail(what + ": the kernel refuses");
}

void FakeKernel::plug(const std::string& name) { interfaces[name] = {next_ifindex++, true, 0}; }

void FakeKernel::unplug(const std::string& name) {
  const auto found = interfaces.find(name);
  if (found == interfaces.end()) return;
  const int gone = found->second.ifindex;
  gates.erase(gone);
  std::erase_if(can_rules, [gone](const net::CanRuleThere& r) {
    return r.rule.from == gone || r.rule.to == gone;
  });
  interfaces.erase(found);
}

void FakeKernel::advance_to(std::uint64_t to) {
  now = to;
  const bool silent = now >= beaten && now - beaten > grace;
  const bool over = until != 0 && now >= until;
  if (lapsed || !open || (!silent && !over)) return;
  lapsed = true;
  ++lapses;
}

const FakeInterface* FakeKernel::interface(int ifindex) const {
  const auto found = std::ranges::find_if(
      interfaces, [ifindex](const auto& known) { return known.second.ifindex == ifindex; });
  return found == interfaces.end() ? nullptr : &found->second;
}

// --- what opens and closes all gates -------------------------------------------------------------

void FakeControl::open() {
  kernel_.open = true;
  kernel_.order.emplace_back("open");
}
void FakeControl::close_all() {
  kernel_.open = false;
  kernel_.order.emplace_back("close");
}
Result<void> FakeControl::set_grace(std::uint64_t grace) {
  if (auto done = kernel_.calls.make("grace"); !done) return done;
  kernel_.grace = grace;
  return {};
}
Result<void> FakeControl::set_until(std::uint64_t until) {
  if (auto done = kernel_.calls.make("set until"); !done) return done;
  kernel_.until = until;
  return {};
}
Result<void> FakeControl::beat(std::uint64_t now) {
  if (auto done = kernel_.calls.make("beat"); !done) return done;
  kernel_.advance_to(now);
  kernel_.beaten = now;
  return {};
}
Result<void> FakeControl::clear_lapse(std::uint64_t now) {
  if (auto done = kernel_.calls.make("clear lapse"); !done) return done;
  kernel_.beaten = now;
  kernel_.lapsed = false;
  return {};
}
Result<void> FakeControl::begin_start(std::uint64_t /*limit*/, std::uint64_t now) {
  if (auto done = kernel_.calls.make("begin start"); !done) return done;
  kernel_.advance_to(now);
  return {};
}
Result<void> FakeControl::undo_interrupted_step() { return kernel_.calls.make("undo"); }
Result<void> FakeControl::arm() { return kernel_.calls.make("arm"); }
Result<bool> FakeControl::keep_pinned() {
  if (const auto done = kernel_.calls.make("pin"); !done) return std::unexpected(done.error());
  return !std::exchange(kernel_.pinned, true);
}
Result<bool> FakeControl::keep_grace() {
  if (const auto done = kernel_.calls.make("keep grace"); !done)
    return std::unexpected(done.error());
  return false;
}
Result<void> FakeControl::listen(GateReports reports) {
  reports_ = std::move(reports);
  return kernel_.calls.make("listen");
}
Result<void> FakeControl::read_reports() {
  if (auto done = kernel_.calls.make("read reports"); !done) return done;
  for (const gate_event& event : std::exchange(events, {})) reports_.event(event);
  return {};
}

// --- interfaces ----------------------------------------------------------------------------------

Result<bool> FakeLinks::refresh() {
  if (const auto done = kernel_.calls.make("links"); !done) {
    problem_ = done.error().text;
    return std::unexpected(done.error());
  }
  problem_.clear();
  const bool changed = known_ != kernel_.interfaces;
  known_ = kernel_.interfaces;
  return changed;
}

std::string FakeLinks::name_of(int ifindex) const {
  for (const auto& [name, link] : known_)
    if (link.ifindex == ifindex) return name;
  return std::to_string(ifindex);
}

// --- gates ---------------------------------------------------------------------------------------

Result<void> FakeGates::prepare(const core::System& system, std::size_t gateway) {
  for (const core::Port& port : system.gateways[gateway].ports) {
    const auto link = links_.known().find(port.identity.name);
    if (link == links_.known().end() || commanded_.contains(link->second.ifindex)) continue;
    // An interface that lacks its gate already does not get worse.
    const bool is_lacking = std::ranges::any_of(
        ports_, [&](const PortState& p) { return p.ifindex == link->second.ifindex; });
    if (auto made = kernel_.calls.make("load"); !made && !is_lacking) {
      end_change();
      return made;
    }
  }
  changing_ = true;
  change_ = {};
  return {};
}

void FakeGates::describe(const core::System& system, std::size_t gateway) {
  std::vector<PortState> next;
  for (const core::Port& port : system.gateways[gateway].ports) {
    const core::Network& network = system.networks[port.network];
    PortState state{port, network.name, network.kind, network.profile, 0, {}, false, false};
    const auto old = std::ranges::find_if(ports_, [&](const PortState& p) {
      return p.port.identity == port.identity && p.network == network.name;
    });
    if (old != ports_.end()) state.ifindex = old->ifindex;
    next.push_back(std::move(state));
  }
  ports_ = std::move(next);
}

Result<void> FakeGates::follow() {
  std::erase_if(commanded_, [this](int ifindex) { return !kernel_.gates.contains(ifindex); });
  for (PortState& port : ports_) match(port);
  close_undescribed();
  for (PortState& port : ports_) {
    if (port.ifindex == 0 || !port.problem.empty()) continue;
    attach(port);
    step_();
  }
  for (PortState& port : ports_) {
    if (port.ifindex == 0 || !port.problem.empty()) continue;
    if (!links_.known().at(port.port.identity.name).up)
      port.problem = port.port.identity.name + " is down";
  }
  return change_;
}

/// Denies everything at the gate of an interface that changes its port.
void FakeGates::match(PortState& port) {
  const auto found = links_.known().find(port.port.identity.name);
  const int now = found == links_.known().end() ? 0 : found->second.ifindex;
  port.problem = now == 0 ? port.port.identity.name + " is absent" : "";
  if (now == 0) port.lost = false;
  if (now == port.ifindex) return;
  for (const int ifindex : {port.ifindex, now})
    if (const auto gate = kernel_.gates.find(ifindex);
        gate != kernel_.gates.end() && commanded_.contains(ifindex))
      gate->second.deny_all();
  port.ifindex = now;
}

void FakeGates::close_undescribed() {
  for (auto& [ifindex, gate] : kernel_.gates)
    if (std::ranges::none_of(ports_, [&](const PortState& p) { return p.ifindex == ifindex; })) {
      gate.rules.clear();
      gate.closed = true;
      commanded_.erase(ifindex);
    }
}

Result<void> FakeGates::hold(const PortState& port) {
  if (!change_) return change_;
  auto done = kernel_.interface(port.ifindex) == nullptr
                  ? Result<void>(fail("the interface has gone"))
                  : kernel_.calls.make("attach");
  if (!done && changing_ && !goes_back_) change_ = done;
  return done;
}

/// Takes over the gate of a former daemon with its slots. If that is refused, no daemon controls
/// it; an interface without a gate gets a program that lets nothing pass.
void FakeGates::attach(PortState& port) {
  if (commanded_.contains(port.ifindex)) return;
  const auto held = hold(port);
  if (held) {
    FakeGate& gate = kernel_.gates[port.ifindex];
    gate.closed = false;
    if (!gate.first_mode) gate.first_mode = kernel_.mode;
    commanded_.insert(port.ifindex);
    port.lost = false;
    return;
  }
  port.problem = held.error().text;
  if (!change_) return;  // the former description stays in force
  if (kernel_.interface(port.ifindex) == nullptr) return;
  const auto former = kernel_.gates.find(port.ifindex);
  if (former != kernel_.gates.end()) {
    port.lost = !former->second.closed;
    return;
  }
  port.lost = !kernel_.calls.make("close");
  if (!port.lost) kernel_.gates[port.ifindex].closed = true;
}

bool FakeGates::repair(int ifindex) {
  if (kernel_.gates.contains(ifindex)) return true;
  commanded_.erase(ifindex);
  return false;
}

bool FakeGates::wants_gate() const {
  return std::ranges::any_of(ports_, [this](const PortState& p) {
    return p.ifindex != 0 && !commanded_.contains(p.ifindex);
  });
}

std::optional<int> FakeGates::next_gate(int ifindex) const {
  const auto next = commanded_.upper_bound(ifindex);
  return next == commanded_.end() ? std::nullopt : std::optional(*next);
}

bool FakeGates::out_of_hand() const { return std::ranges::any_of(ports_, &PortState::lost); }

FakeGate* FakeGates::gate_of(std::size_t port) const {
  const int ifindex = ports_[port].ifindex;
  if (!commanded_.contains(ifindex)) return nullptr;
  const auto found = kernel_.gates.find(ifindex);
  return found == kernel_.gates.end() ? nullptr : &found->second;
}

int FakeGates::gated_interface(std::size_t port) const {
  return gate_of(port) == nullptr ? 0 : ports_[port].ifindex;
}

/// The entry with ifindexes in place of ports; nullopt if its source is absent.
std::optional<core::GateEntry> FakeGates::placed(const core::GateEntry& entry) const {
  core::GateEntry out = entry;
  out.port = static_cast<std::size_t>(ports_[entry.port].ifindex);
  if (!entry.source_port) return out;
  const int source = ports_[*entry.source_port].ifindex;
  if (source == 0) return std::nullopt;
  out.source_port = static_cast<std::size_t>(source);
  return out;
}

std::optional<core::GateState> FakeGates::share_of(std::size_t port,
                                                   const core::GateState& wanted) const {
  if (gate_of(port) == nullptr) return std::nullopt;
  core::GateState share;
  for (const core::GateRule& rule : wanted)
    if (rule.entry.port == port)
      if (const auto entry = placed(rule.entry)) {
        share.push_back(rule);
        share.back().entry = *entry;
      }
  std::ranges::sort(share, {}, &core::GateRule::entry);
  return share;
}

Result<void> FakeGates::sync(const core::GateState& wanted) {
  kernel_.order.emplace_back("sync");
  std::string problems;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const auto share = share_of(p, wanted);
    if (!share) continue;
    FakeGate& gate = *gate_of(p);
    std::map<core::GateEntry, core::GateRule> rules;
    for (const core::GateRule& rule : *share) rules.emplace(rule.entry, rule);
    ports_[p].refused = false;
    if (gate.rules == rules) continue;
    if (const auto done = kernel_.calls.make("sync " + ports_[p].network)) {
      gate.rules = std::move(rules);
    } else {
      gate.deny_all();
      ports_[p].refused = true;
      problems += (problems.empty() ? "" : "; ") + done.error().text;
    }
  }
  if (!problems.empty()) return fail(problems);
  return {};
}

Result<void> FakeGates::change(std::size_t port, const std::string& what,
                               const std::function<void(FakeGate&)>& make) {
  FakeGate* const gate = gate_of(port);
  if (gate == nullptr) return {};
  if (auto done = kernel_.calls.make(what + ' ' + ports_[port].network); !done) return done;
  make(*gate);
  return {};
}

/// After a refusal the changes before it stay.
Result<void> FakeGates::apply(const core::GateChanges& changes) {
  kernel_.order.emplace_back("apply");
  Result<void> done;
  const auto each = [&](const auto& list, const char* what, const auto& make) {
    for (const auto& item : list) {
      const auto& entry = [&]() -> const core::GateEntry& {
        if constexpr (requires { item.entry; })
          return item.entry;
        else
          return item;
      }();
      const auto where = placed(entry);
      if (!done || !where) continue;
      done = change(entry.port, what, [&](FakeGate& gate) { make(gate, *where, item); });
    }
  };
  const auto set_pass = [](bool pass) {
    return [pass](FakeGate& gate, const core::GateEntry& at, const auto& /*item*/) {
      if (const auto found = gate.rules.find(at); found != gate.rules.end())
        found->second.pass = pass;
    };
  };
  each(changes.close, "close", set_pass(false));
  each(changes.remove, "remove",
       [](FakeGate& gate, const core::GateEntry& at, const auto&) { gate.rules.erase(at); });
  each(changes.add, "add",
       [](FakeGate& gate, const core::GateEntry& at, const core::GateRule& rule) {
         core::GateRule added = rule;
         added.entry = at;
         added.pass = false;
         gate.rules.insert_or_assign(at, added);
       });
  each(changes.open, "open", set_pass(true));
  each(changes.add, "open",
       [](FakeGate& gate, const core::GateEntry& at, const core::GateRule& rule) {
         gate.rules.at(at).pass = rule.pass;
       });
  each(changes.police, "police",
       [](FakeGate& gate, const core::GateEntry& at, const core::GateRule& rule) {
         const auto found = gate.rules.find(at);
         if (found == gate.rules.end()) return;
         found->second.policing = rule.policing;
         found->second.watching = rule.watching;
       });
  return done;
}

std::vector<gates::PlacedSlot> FakeGates::slots(std::span<const core::GateRule> rules) const {
  std::vector<gates::PlacedSlot> placed_slots;
  for (const core::GateRule& rule : rules)
    if (const auto entry = placed(rule.entry); entry && gate_of(rule.entry.port) != nullptr)
      placed_slots.push_back(
          {static_cast<std::uint32_t>(entry->port),
           gates::slot_of(rule, ports_[rule.entry.port].kind,
                          static_cast<std::uint32_t>(entry->source_port.value_or(0)))});
  return placed_slots;
}

Frames FakeGates::frames(const core::GateState& rules,
                         const std::vector<core::GateEntry>& /*shared*/) const {
  if (rules.empty()) return {};
  if (const auto one = passed.find(rules.front().entry.direction);
      rules.size() == 1 && one != passed.end())
    return {.passed = one->second, .last_reason = {}};
  if (before_frames) before_frames();
  const auto found = counted.find(rules.front().entry.subject);
  return found == counted.end() ? Frames{} : found->second;
}

bool FakeGates::is_of(const gate_event& event, const core::GateState& rules) const {
  return std::ranges::any_of(
      rules, [&](const core::GateRule& r) { return r.entry.subject == event.subject; });
}

std::size_t FakeGates::slot_count() const {
  std::size_t sum = 0;
  for (const int ifindex : commanded_)
    if (const auto gate = kernel_.gates.find(ifindex); gate != kernel_.gates.end())
      sum += gate->second.rules.size();
  return sum;
}

std::vector<core::Condition> FakeGates::conditions(std::size_t networks) const {
  std::vector<core::Condition> out(networks);
  for (const PortState& port : ports_) {
    core::Condition& condition = out[port.port.network];
    condition.available = port.problem.empty();
    condition.problem = port.problem;
    if (const auto link = links_.known().find(port.port.identity.name);
        link != links_.known().end())
      condition.timing.bitrate = link->second.bitrate;
  }
  return out;
}

std::optional<BusCounters> FakeGates::bus_counters(std::size_t port) {
  const auto found = carried.find(ports_[port].port.identity.name);
  return found == carried.end() ? std::nullopt : std::optional(found->second);
}

UnknownFrames FakeGates::unknown_frames(std::size_t port) const {
  const auto found = unknown.find(ports_[port].port.identity.name);
  return found == unknown.end() ? UnknownFrames{} : found->second;
}

std::vector<gates::UnknownFrame> FakeGates::seen_unknown(std::size_t port) const {
  const auto found = seen.find(ports_[port].port.identity.name);
  return found == seen.end() ? std::vector<gates::UnknownFrame>() : found->second;
}

std::vector<Refusals> FakeGates::refusals(std::size_t port) const {
  const auto found = refused.find(ports_[port].port.identity.name);
  return found == refused.end() ? std::vector<Refusals>() : found->second;
}

std::vector<Refusals> FakeGates::misfits(std::size_t port) const {
  const auto found = misfitting.find(ports_[port].port.identity.name);
  return found == misfitting.end() ? std::vector<Refusals>() : found->second;
}

std::vector<control::Interface> FakeGates::report() const {
  std::vector<control::Interface> out;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    control::Interface i;
    i.name = ports_[p].port.identity.name;
    i.network = ports_[p].network;
    i.identity = "name " + i.name;
    i.ifindex = static_cast<std::uint32_t>(ports_[p].ifindex);
    i.problem = ports_[p].problem;
    i.attached = gate_of(p) != nullptr;
    out.push_back(std::move(i));
  }
  return out;
}

// --- work beside the loop, and can-gw ------------------------------------------------------------

bool FakeBackground::begin(std::function<void()> work, std::function<void()> done) {
  if (busy()) return false;
  work_ = std::move(work);
  done_ = std::move(done);
  begun_ = clock_.monotonic_ns();
  return true;
}

void FakeBackground::finish() {
  const auto work = std::exchange(work_, nullptr);
  const auto done = std::exchange(done_, nullptr);
  works = true;
  if (work) work();
  works = false;
  if (done) done();
}

Result<std::vector<net::CanRuleThere>> FakeCanRules::read() {
  if (const auto done = kernel_.calls.make("can-gw"); !done) return std::unexpected(done.error());
  return kernel_.can_rules;
}
Result<void> FakeCanRules::add(const net::CanRuleThere& rule) {
  if (auto done = kernel_.calls.make("can-gw add"); !done) return done;
  kernel_.can_rules.push_back(rule);
  return {};
}
Result<void> FakeCanRules::remove(const net::CanRuleThere& rule) {
  if (auto done = kernel_.calls.make("can-gw remove"); !done) return done;
  if (std::erase(kernel_.can_rules, rule) == 0) return fail("no such rule");
  return {};
}

}  // namespace mlcca::test
