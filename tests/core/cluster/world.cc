// SPDX-License-Identifier: BSD-2-Clause
#include "tests/core/cluster/world.hpp"

#include <algorithm>

#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster::test {
namespace {

constexpr Value kMillion = 1'000'000;
const TextCodec kCodec;
const std::array kCodecs{DescriptionCodec(0), DescriptionCodec(1), DescriptionCodec(2),
                         DescriptionCodec(3)};

template <class... F>
struct Cases : F... {
  using F::operator()...;
};

}  // namespace

std::shared_ptr<const Keys> keys_of(std::size_t gateways) {
  System system;
  for (const char* name : {"bus", "side"}) {
    Network network;
    network.name = name;
    system.networks.push_back(network);
  }
  for (std::size_t g = 0; g < gateways; ++g) {
    Gateway gateway;
    gateway.name = std::string(1, static_cast<char>('A' + g));
    for (std::size_t n = 0; n < 2; ++n) {
      Port port;
      port.network = n;
      gateway.ports.push_back(port);
    }
    system.gateways.push_back(gateway);
  }
  return std::make_shared<const Keys>(system, "");
}

World::World(const Scenario& scenario, std::shared_ptr<const Keys> keys)
    : scenario_(&scenario),
      keys_(std::move(keys)),
      without_last_(scenario.removes ? keys_of(scenario.gateways - 1) : keys_),
      hosts_(scenario.gateways),
      wants_(scenario.wants) {
  releases_ = scenario.releases;
  replaces_ = scenario.replaces;
  lates_ = scenario.late;
  lost_ = scenario.lost;
  twice_ = scenario.twice;
  stalls_ = scenario.stalls;
  pauses_ = scenario.pauses;
  crashes_ = scenario.crashes;
  fences_ = scenario.fences;
  compactions_ = scenario.compactions;
  outages_ = scenario.outages;
  restores_ = scenario.restores;
  refusals_ = scenario.refusals;
  drains_ = scenario.drains;
  objections_ = scenario.objections;
  cannots_ = scenario.cannots;
  cancels_ = scenario.cancels;
  ordered_.assign(scenario.orders.size(), false);
  store_.write(
      {{.key = keys_->current(),
        .value = kCodec.write(
            Current{.generation = 1, .digest = TextCodec::digest(1), .open = true, .waits = {}})}});
  for (std::size_t g = 0; g < hosts_.size(); ++g) start(g);
  // All gateways join before anything else happens.
  for (int round = 0; round < 40; ++round) {
    const auto all = steps(false);
    const auto it = std::ranges::find_if(all, [](const Step& s) {
      return s.kind != Step::Kind::time && s.kind != Step::Kind::want &&
             s.kind != Step::Kind::roll_out;
    });
    if (it != all.end()) take(*it);
  }
  now_ = 0;
  backup_ = store_;
}

Value World::clock(std::size_t g) const {
  const int ppm = scenario_->clock_ppm[g];
  const Value rate = kMillion + static_cast<Value>(ppm);
  return (1000 + (5000 * g)) * kStep + mul_div_down(real(), rate, kMillion);
}
Value World::real_of(std::size_t g, Value local) const {
  const int ppm = scenario_->clock_ppm[g];
  const Value rate = kMillion + static_cast<Value>(ppm);
  return mul_div_up(sub_floor(local, (1000 + (5000 * g)) * kStep), kMillion, rate);
}

void World::start(std::size_t g) {
  Host& host = hosts_[g];
  ++host.process;
  begin_process(g);
  host.member.emplace(host.rollout.loaded == kWithoutLast ? without_last_ : keys_,
                      kCodecs[host.rollout.loaded],
                      Member::Identity{.gateway = g,
                                       .digest = TextCodec::digest(host.rollout.loaded),
                                       .session = (g * 100) + host.process,
                                       .lease = kLease,
                                       .was = host.journal,
                                       .first_wait = scenario_->waits ? Admissions::kFirstWait : 0,
                                       .rollout_patience = rolls_out() ? scenario_->patience * kStep
                                                                       : Rollouts::kPatience});
  host.paused = host.stalled = host.synced = host.drained = false;
  host.flight.reset();
  host.former.reset();
  host.failed.assign(hosts_.size(), true);
  host.found.clear();
  host.agreed.clear();
  host.replaces.clear();
  host.member->on_state({.reachable = true, .endpoint = {}, .problem = {}}, clock(g));
  turn(g);
}

bool World::in_gate(std::size_t g, const Gate& gate) const {
  return gate.open && clock(g) < hosts_[g].until;
}

/// Whether frames of the gate may still leave, also from a queue behind it. A clock that is wrong
/// by kClockError measures the time of kQueued.
bool World::on_wire(std::size_t g, const Gate& gate) const {
  if (in_gate(g, gate)) return true;
  const Value until = real_of(g, hosts_[g].until);
  const Value closed = gate.open ? until : std::min(gate.closed, std::max<Value>(until, 1));
  return closed != 0 && real() < closed + mul_div_down(kQueued, kMillion, kMillion + kClockError);
}

void World::close_gate(std::size_t g, Gate& gate) {
  if (!gate.open) return;
  gate.closed = std::min(real(), real_of(g, hosts_[g].until));
  gate.open = false;
}
void World::close(std::size_t g, const Admission& admission) {
  const auto it = hosts_[g].gates.find(admission);
  if (it != hosts_[g].gates.end()) close_gate(g, it->second);
}

void World::answer(std::size_t g, std::uint64_t id, int what) {
  int& had = hosts_[g].answers[id];
  if (had != 0) broken_ = "an admission has two answers";
  had = what;
}

bool World::fits(std::size_t g) const {
  const Foreign others = hosts_[g].member->view().foreign(kBus);
  const bool own = std::ranges::any_of(hosts_[g].answers, [&](const auto& entry) {
    return entry.second == 0 || hosts_[g].held.contains(entry.first);
  });
  if (serves(g)) return is_all_agreed(g);
  return (!own || scenario_->subscribers != 0) && !others.unreadable && bytes_of(others.rates) == 0;
}

std::vector<std::size_t> World::way_of(std::size_t g) const {
  if (scenario_->way && g == 0) return {1};
  if (scenario_->behalf && g == 1) return {0};
  return {};
}

/// Who asks another gateway to make the admission reserves nothing itself.
void World::ask(std::size_t g, std::uint64_t id, const std::vector<std::size_t>& on_way) {
  Host& host = hosts_[g];
  host.answers[id] = 0;
  std::vector<Part> parts;
  if (!scenario_->behalf || g != 1) parts.push_back(part_of(kBus, 1));
  host.member->reserve({.id = id, .footprint = {.parts = std::move(parts), .gateways = on_way}},
                       clock(g));
}

void World::on_joined(std::size_t g) {
  Host& host = hosts_[g];
  for (const std::uint64_t id : std::set(host.held))
    if (!host.found.contains(id)) {
      close(g, {g, id});
      host.held.erase(id);
    }
  for (const std::uint64_t id : host.found)
    if (!host.held.contains(id)) host.member->release(id, clock(g));
}

void World::act(std::size_t g, const Event& event) {
  Host& host = hosts_[g];
  Member& member = *host.member;
  std::visit(Cases{
                 [&](const Reserved& e) {
                   answer(g, e.id, 1);
                   if (scenario_->behalf && g == 1 && !made_.contains({g, e.id}))
                     broken_ = "an admission is granted that the other gateway has not made";
                   if ((makes_for_others(g) && made_for(g, e.id) == nullptr) ||
                       is_replaced_in_vain(g, e.id))
                     return member.release(e.id, clock(g));
                   host.held.insert(e.id);
                   // V is stored in the kernel before the gate opens.
                   host.until = member.valid_until();
                   if (serves(g)) on_agreed(g, e.id);
                   if (!scenario_->behalf || g != 1) open_gate(g, {g, e.id});
                   end_replaced(g, e.id);
                   vote_as(g, e.id, true);
                 },
                 [&](const Refused& e) {
                   answer(g, e.id, 2);
                   keep_replaced(g, e.id);
                   if (serves(g)) on_refused(g, e.id, e.by && e.why.final);
                   vote_as(g, e.id, false);
                 },
                 [&](const Conflict& e) {
                   const Origin* const origin = made_for(g, e.id);
                   const bool wanted = !makes_for_others(g) || origin != nullptr;
                   if (wanted && bytes_of(member.view().foreign(kBus).rates) == 0) {
                     ask(g, e.id, origin == nullptr ? way_of(g) : std::vector{origin->gateway});
                     return;
                   }
                   answer(g, e.id, 2);
                   keep_replaced(g, e.id);
                   vote_as(g, e.id, false);
                   member.release(e.id, clock(g));
                 },
                 [&](const Withdrawn& e) {
                   close(g, {g, e.id});
                   host.held.erase(e.id);
                   if (serves(g)) on_refused(g, e.id, e.by && e.why.final);
                   vote_as(g, e.id, false);
                   member.release(e.id, clock(g));
                 },
                 [&](const Lost&) {
                   for (auto& [admission, gate] : host.gates) close_gate(g, gate);
                   close_gate(g, host.ways);
                   host.held.clear();
                   host.agreed.clear();
                   host.behalf.clear();
                   host.rollout.opened.clear();
                 },
                 [&](const Found& e) { host.found.insert(e.id); },
                 [&](const Joined&) {
                   on_joined(g);
                   host.joined = true;
                 },
                 [&](const Adopt& e) {
                   if (makes_for_others(g)) return adopt_behalf(g, e.origin);
                   host.agreed[e.origin] = true;
                   // What another description has reserved cannot be read.
                   const bool ok = !rolls_out() || !e.footprint.parts.empty();
                   member.vote(e.origin, {.ok = ok, .hop = {}, .reason = {}}, clock(g));
                 },
                 [&](const Opened& e) {
                   if (!makes_for_others(g)) open_gate(g, {e.origin.gateway, e.origin.id});
                 },
                 [&](const Ended& e) {
                   check_replaced(g, e.origin);
                   close(g, {e.origin.gateway, e.origin.id});
                   host.agreed.erase(e.origin);
                   host.rollout.opened.erase({e.origin.gateway, e.origin.id});
                   end_behalf(g, e.origin);
                 },
                 [&](const Failed& e) { host.failed[e.gateway] = e.failed; },
                 [](const auto&) {},
             },
             event);
}

/// The first gateway that has not failed carries the traffic that all could carry.
void World::set_way(std::size_t g) {
  Host& host = hosts_[g];
  bool carries = scenario_->elect && !host.drained;
  for (std::size_t other = 0; other <= g; ++other)
    carries = carries && host.failed[other] == (other != g);
  if (scenario_->mutant == Mutant::active_without_asking && scenario_->elect) {
    carries = host.member->role() != Role::standby;
    for (std::size_t other = 0; other < g; ++other) carries = carries && host.failed[other];
  }
  if (carries)
    host.ways = {.open = true};
  else
    close_gate(g, host.ways);
}

/// Closes what the previous process has adopted and this one has not.
void World::close_strange(std::size_t g) {
  for (auto& [admission, gate] : hosts_[g].gates)
    if (admission.first != g && std::ranges::none_of(hosts_[g].agreed, [&](const auto& entry) {
          return entry.first.gateway == admission.first && entry.first.id == admission.second;
        }))
      close_gate(g, gate);
}

void World::turn(std::size_t g) {
  Host& host = hosts_[g];
  for (auto events = host.member->take_events(); !events.empty();
       events = host.member->take_events())
    for (const Event& event : events) {
      act(g, event);
      on_rollout(g, event);
    }
  if (std::exchange(host.joined, false)) {
    close_strange(g);
    end_strange_behalf(g);
  }
  step_behalf(g);
  follow_agreements(g);
  set_way(g);
  put_permits(g);
  const Value slack =
      scenario_->mutant == Mutant::clock_error_ignored ? kLease * kClockError / kMillion : 0;
  if (host.member->valid_until() != 0) host.until = host.member->valid_until() + slack;
  if (scenario_->mutant == Mutant::valid_from_answer && host.answered_at != 0)
    host.until = std::max(host.until, valid_until(host.answered_at, kLease));
  host.member->applied(host.member->view().revision());
  auto txns = host.member->take_txns(clock(g));
  host.journal = host.member->journalled();
  for (Txn& txn : txns) send(g, std::move(txn));
}

void World::send(std::size_t g, Txn txn) {
  Host& host = hosts_[g];
  if (host.flight && !host.flight->result)
    late_.push_back({.gateway = g, .process = host.process, .txn = std::move(host.flight->txn)});
  const bool beat = txn.puts.size() == 1 && txn.deletes.empty() && txn.puts[0].key[0] == 'm';
  const auto drop = [&](char kind, std::optional<Compare::Is> is) {
    std::erase_if(txn.compares,
                  [&](const Compare& c) { return c.key[0] == kind && (!is || c.is == *is); });
  };
  switch (scenario_->mutant) {
    case Mutant::fence_without_compare:
      if (!txn.puts.empty() && txn.puts.back().key[0] == 'f')
        std::erase_if(txn.compares, [&](const Compare& c) {
          return c.key == keys_->member(*keys_->gateway(txn.puts.back().key.substr(2)));
        });
      break;
    case Mutant::grant_without_version:
      drop('v', std::nullopt);
      break;
    case Mutant::no_fence_compare:
      drop('f', std::nullopt);
      break;
    case Mutant::no_chain:
      drop('m', Compare::Is::equal);
      break;
    case Mutant::open_before_votes:
      for (Put& put : txn.puts)
        if (put.key[0] == 'x' && put.value[0] == '0') put.value[0] = '1';
      break;
    case Mutant::ended_at_once:
      if (!txn.puts.empty() && txn.puts.back().key[0] == 'x' && txn.puts.back().value[0] == '2')
        txn.deletes.push_back("r/bus/A/" + txn.puts.back().key.substr(4));
      break;
    default:
      break;
  }
  mutate_rollout(txn);
  host.flight = Flight{.txn = std::move(txn), .beat = beat, .result = std::nullopt};
}

/// A gateway that is not hostile fences only gateways that do not send any more.
void World::check_fence(const Txn& txn) {
  for (const Put& put : txn.puts)
    if (put.key[0] == 'f') {
      const std::size_t victim = *keys_->gateway(put.key.substr(2));
      if (real() < real_of(victim, hosts_[victim].until))
        broken_ = "a gateway whose lease lasts was fenced";
    }
}

TxnResult World::do_txn(const Txn& txn) {
  const auto it = store_.entries.find(keys_->next());
  const Entry next = it == store_.entries.end() ? Entry{} : it->second;
  TxnResult result = store_.apply(txn);
  if (result.outcome == Outcome::committed) note_decision(txn, next);
  if (result.outcome == Outcome::committed) check_fence(txn);
  return result;
}

void World::deliver(std::size_t g, const TxnResult& result) {
  Host& host = hosts_[g];
  if (result.outcome == Outcome::committed) host.answered_at = clock(g);
  host.member->on_result(result, clock(g));
  turn(g);
}

void World::watch(std::size_t g) {
  Host& host = hosts_[g];
  Batch batch = store_.log[host.seen++];
  if (scenario_->mutant == Mutant::freed_on_fence_alone)
    for (const Entry& entry : Batch(batch).entries)
      if (entry.key[0] == 'f' && entry.key.substr(2) != keys_->gateway_name(g))
        for (const auto& [key, held] : store_.entries)
          if (key.starts_with("r/bus/" + entry.key.substr(2)))
            batch.entries.push_back({.key = key, .value = {}, .mod = batch.revision, .gone = true});
  mutate_seen(g, batch);
  host.member->on_batch(batch, clock(g));
  turn(g);
}

void World::read_all(std::size_t g) {
  Host& host = hosts_[g];
  host.member->on_snapshot_begin(store_.revision, clock(g));
  Batch all = store_.snapshot();
  mutate_seen(g, all);
  host.member->on_batch(all, clock(g));
  host.member->on_snapshot_end(clock(g));
  host.seen = store_.log.size();
  host.synced = true;
  turn(g);
}

void World::pass_time() {
  ++now_;
  check();
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    if (!runs(g)) continue;
    hosts_[g].member->on_time(clock(g));
    turn(g);
  }
}

}  // namespace mlcca::core::cluster::test
