// SPDX-License-Identifier: BSD-2-Clause
// Rollouts as the daemon takes part in them, and what must hold meanwhile.
#include <algorithm>
#include <set>

#include "core/cluster/lease.hpp"
#include "mlcca/arithmetic.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {
namespace {

constexpr Value kAwaits = 2 * kStep;                    // how long a start waits for the store
constexpr Value kGrace = kLease;                        // until gates close without heart-beats
constexpr Value kInQueue = kQueued - (kQueued / 1000);  // by a clock that is wrong by kClockError
const Digest kFile = TextCodec::digest(1);
const TextCodec kRecords;

}  // namespace

bool World::is_removed(std::size_t g, const Digest& description) const {
  return scenario_->removes && g + 1 == hosts_.size() &&
         description == TextCodec::digest(kWithoutLast);
}

bool World::is_removed(std::size_t g) const {
  return is_removed(g, kRecords.current(store_.entries.at(keys_->current()).value)->digest);
}

/// Whether the description that is loaded is in force, by what the gateway knows.
bool World::is_in_force(std::size_t g) const {
  const Host& host = hosts_[g];
  const auto& current = host.member->view().records().current.value;
  return host.member->view().complete() && current && current->open &&
         current->digest == TextCodec::digest(host.rollout.loaded);
}

/// Whether what concerns shared networks may be open.
bool World::may_use(std::size_t g) const {
  const Host& host = hosts_[g];
  const RolloutSide& side = host.rollout;
  const bool heard =
      side.lapsed_at == 0 || host.member->valid_until() >= valid_until(side.lapsed_at, kLease);
  return !rolls_out() || (side.joined && heard && !host.drained && is_in_force(g));
}

void World::open_gate(std::size_t g, const Admission& admission) {
  if (admission.first != g) hosts_[g].rollout.opened.insert(admission);
  if (!may_use(g)) return;
  Gate& gate = hosts_[g].gates[admission];
  const std::uint8_t of = hosts_[g].rollout.loaded;
  if (gate.description != of && on_wire(g, gate))
    broken_ = "what is sent by a description meets what is in a queue by another one";
  gate = {.open = true, .description = of};
}

// --- processes -----------------------------------------------------------------------------------

void World::begin_process(std::size_t g) {
  RolloutSide& side = hosts_[g].rollout;
  go_on(g);
  side.loaded = side.following.replaces(kFile) ? side.following.rolled[0] : kFile[0];
  side.joined = false;
  side.lapsed_at = 0;
  side.awaits = real() + kAwaits;
  side.to_judge.reset();
  side.opened.clear();
  side.state = RolloutSide::State::none;
}

/// No heart-beat comes any more.
void World::stop_process(std::size_t g) {
  RolloutSide& side = hosts_[g].rollout;
  if (side.dead_from == 0) side.dead_from = real() + kGrace;
}

/// Heart-beats come again. What has closed without them stays closed.
void World::go_on(std::size_t g) {
  RolloutSide& side = hosts_[g].rollout;
  if (side.open && side.dead_from != 0 && real() >= side.dead_from) {
    side.open = false;
    side.closed = side.dead_from;
    if (scenario_->mutant != Mutant::open_unheard) side.lapsed_at = clock(g);
  }
  side.dead_from = 0;
}

void World::load(std::size_t g) {
  Host& host = hosts_[g];
  RolloutSide& side = host.rollout;
  if (host.flight && !host.flight->result)
    late_.push_back({.gateway = g, .process = host.process, .txn = host.flight->txn});
  for (const auto& [id, what] : std::map(host.answers))
    if (what == 0) answer(g, id, 2);
  for (auto& [admission, gate] : host.gates) close_gate(g, gate);
  host.held.clear();
  side.following.note_loaded(*side.following.wanted, kFile);
  const auto state = side.state;
  start(g);
  side.state = state;
  side.awaits = 0;
  if (state == RolloutSide::State::open) host.member->resume_rollout(side.own);
  put_permits(g);
}

/// Whatever is reserved or promised is open as long as the description is in force.
void World::put_permits(std::size_t g) {
  if (!rolls_out()) return;
  Host& host = hosts_[g];
  RolloutSide& side = host.rollout;
  const bool may = may_use(g);
  if (!may && side.open && side.awaits == 0 && scenario_->mutant == Mutant::said_before_closed)
    side.awaits = real() + kAwaits;
  const bool waits = scenario_->mutant == Mutant::said_before_closed || !side.joined;
  if (real() < side.awaits && waits) return;
  side.awaits = 0;
  const bool promised = scenario_->mutant == Mutant::described_stays_open ? side.joined : may;
  if (promised && !side.open) {
    if (side.of != side.loaded && described_on_wire(g))
      broken_ = "what is promised by a description meets what is in a queue by another one";
    side.open = true;
    side.of = side.loaded;
  } else if (!promised && side.open) {
    side.open = false;
    side.closed = real();
  }
  std::set<Admission> all = side.opened;
  for (const std::uint64_t id : host.held) all.emplace(g, id);
  for (const Admission& admission : all)
    if (!may)
      close(g, admission);
    else if (const auto it = host.gates.find(admission); it != host.gates.end() && !it->second.open)
      open_gate(g, admission);
}

// --- what the store says -------------------------------------------------------------------------

void World::on_rollout(std::size_t g, const Event& event) {
  using enum RolloutSide::State;
  RolloutSide& side = hosts_[g].rollout;
  if (std::holds_alternative<Lost>(event)) {
    side.awaits = 0;
  } else if (std::holds_alternative<Joined>(event)) {
    side.joined = true;
    side.lapsed_at = 0;
  } else if (const auto* judge = std::get_if<Judge>(&event)) {
    side.to_judge = judge->digest;
  } else if (std::holds_alternative<NotRolledOut>(event)) {
    if (side.state != open) return;
    side.state = refused;
    const auto entry = store_.entries.find(keys_->next());
    const auto next =
        entry == store_.entries.end() ? std::nullopt : kRecords.next(entry->second.value);
    if (next && next->by == keys_->gateway_name(g) && next->digest == side.own)
      refused_.insert(entry->second.mod);
  } else if (const auto* to = std::get_if<Switch>(&event)) {
    side.following.on(*to, TextCodec::digest(side.loaded));
    const bool ours = side.own == to->digest && side.state != none && side.state != refused;
    if (ours)
      side.state = to->open ? in_force : switching;
    else if (side.state == switching)
      side.state = refused;
  }
}

// --- steps ---------------------------------------------------------------------------------------

Digest World::ordered(const Order& order) const {
  if (!order.back) return TextCodec::digest(order.description);
  const auto& current = hosts_[order.gateway].member->view().records().current.value;
  if (!current) return {};
  return current->undone && !current->open ? current->digest : current->former;
}

bool World::has_begun_rollout() const {
  const auto off = [this](const Order& order) {
    return std::ranges::any_of(
        order.off, [this](const std::string& name) { return !runs(*keys_->gateway(name)); });
  };
  return std::ranges::find(ordered_, true) != ordered_.end() ||
         std::ranges::any_of(scenario_->orders, off);
}

bool World::may_order(const Order& order) const {
  const std::size_t g = order.gateway;
  if (!runs(g) || hosts_[g].rollout.state == RolloutSide::State::open) return false;
  const Member& member = *hosts_[g].member;
  // An operator calls off who is off, and is told before that it is not known to be dead.
  for (const std::string& name : order.off)
    if (runs(*keys_->gateway(name)) || !member.view().is_fenced(*keys_->gateway(name)))
      return false;
  const auto standing = member.standing(clock(g));
  const auto& records = member.view().records();
  return (standing == Member::Standing::joined || standing == Member::Standing::other_digest) &&
         (records.next.mod == 0 || Rollouts::gives_way(records, order.off)) &&
         ordered(order) != Digest{};
}

void World::add_rollout_steps(std::vector<Step>& all) const {
  for (std::size_t g = 0; rolls_out() && g < hosts_.size(); ++g) {
    if (!runs(g)) continue;
    const RolloutSide& side = hosts_[g].rollout;
    if (cancels_ > 0 && to_cancel(g)) all.push_back({.kind = Step::Kind::cancel, .gateway = g});
    if (side.to_judge) all.push_back({.kind = Step::Kind::judge, .gateway = g});
    if (side.following.wanted) all.push_back({.kind = Step::Kind::load, .gateway = g});
  }
  for (std::size_t n = 0; n < ordered_.size(); ++n)
    if (!ordered_[n] && may_order(scenario_->orders[n]))
      all.push_back(
          {.kind = Step::Kind::roll_out, .gateway = scenario_->orders[n].gateway, .index = n});
}

void World::take_rollout(const Step& step) {
  switch (step.kind) {
    case Step::Kind::roll_out:
      ordered_[step.index] = true;
      return roll_out(scenario_->orders[step.index]);
    case Step::Kind::cancel:
      return cancel(step.gateway);
    case Step::Kind::judge:
      return judge(step.gateway, !is_removed(step.gateway, *hosts_[step.gateway].rollout.to_judge));
    case Step::Kind::object:
      --objections_;
      return judge(step.gateway, false);
    case Step::Kind::load:
      return is_removed(step.gateway, *hosts_[step.gateway].rollout.following.wanted)
                 ? cannot_load(step.gateway)
                 : load(step.gateway);
    default:
      --cannots_;
      return cannot_load(step.gateway);
  }
}

void World::roll_out(const Order& order) {
  using enum RolloutSide::State;
  Host& host = hosts_[order.gateway];
  RolloutSide& side = host.rollout;
  side.own = ordered(order);
  const auto& current = host.member->view().records().current.value;
  if (current && current->digest == side.own && (current->open || order.off.empty())) {
    side.state = current->open ? in_force : switching;
    return;
  }
  side.state = open;
  host.member->stage({.digest = side.own, .chunks = {"x"}, .without = order.off});
  host.member->on_time(clock(order.gateway));
  turn(order.gateway);
}

/// What an operator would give up at that gateway, as the daemon decides it; nullopt: nothing.
std::optional<Digest> World::to_cancel(std::size_t g) const {
  const auto& records = hosts_[g].member->view().records();
  const auto& current = records.current.value;
  const RolloutSide& side = hosts_[g].rollout;
  if (records.next.value) return records.next.value->digest;
  if (current && !current->open && !current->undone) return current->digest;
  return side.state == RolloutSide::State::open ? std::optional(side.own) : std::nullopt;
}

void World::cancel(std::size_t g) {
  --cancels_;
  hosts_[g].member->cancel_rollout(*to_cancel(g), "given up");
  hosts_[g].member->on_time(clock(g));
  turn(g);
}

void World::judge(std::size_t g, bool ok) {
  RolloutSide& side = hosts_[g].rollout;
  const Digest digest = *side.to_judge;
  side.to_judge.reset();
  if (ok) side.following.voted = digest;
  side.agreed_to = ok ? hosts_[g].member->view().records().next.mod : 0;
  hosts_[g].member->vote_rollout(digest, ok, ok ? "" : "no");
  turn(g);
}

void World::cannot_load(std::size_t g) {
  Host& host = hosts_[g];
  RolloutSide& side = host.rollout;
  const auto& current = host.member->view().records().current.value;
  if (current && current->digest == *side.following.wanted) host.member->cannot_switch("no");
  side.following.wanted.reset();
  turn(g);
}

// --- what must hold ------------------------------------------------------------------------------

/// A vote against a proposal keeps it from ever coming into force, and what was given up or taken
/// back does not open any more. `next`: the proposal before the transaction.
void World::note_cancelled(const Txn& txn, const Entry& next) {
  if (scenario_->cancels == 0) return;
  for (const Put& put : txn.puts)
    if (const auto vote =
            put.key.starts_with("d/vote/") ? kRecords.rollout_vote(put.value) : std::nullopt;
        vote && !vote->ok)
      objected_.insert(vote->next);
  const auto current = std::ranges::find(txn.puts, keys_->current(), &Put::key);
  const bool ends = std::ranges::find(txn.deletes, keys_->next()) != txn.deletes.end();
  const auto proposed = kRecords.next(next.value);
  if (current == txn.puts.end()) {
    if (ends && proposed) over_.insert(proposed->digest);
    return;
  }
  const auto to = *kRecords.current(current->value);
  if (ends && objected_.contains(next.mod))
    broken_ = "a rollout comes into force that was given up before";
  if (to.open && over_.contains(to.digest)) broken_ = "a rollout that was given up opens";
  if (to.undone) over_.insert(to.former);
}

/// `next`: the proposal before the transaction.
void World::note_decision(const Txn& txn, const Entry& next) {
  note_cancelled(txn, next);
  const auto put = std::ranges::find(txn.puts, keys_->current(), &Put::key);
  if (put == txn.puts.end()) return;
  const auto to = *kRecords.current(put->value);
  if (!to.open &&
      !(to.undone ? to.digest == was_open_ : to.former == was_open_ || to.digest == was_open_))
    broken_ = "the description before is not the one that was in force last";
  if (to.open) was_open_ = to.digest;
  if (std::ranges::find(txn.deletes, keys_->next()) == txn.deletes.end()) return;
  if (refused_.contains(next.mod))
    broken_ = "a rollout comes into force after it was answered that it does not";
  const auto proposed = kRecords.next(next.value);
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    const bool off = proposed && std::ranges::find(proposed->without, keys_->gateway_name(g)) !=
                                     proposed->without.end();
    const auto by = proposed ? keys_->gateway(proposed->by) : std::nullopt;
    const bool unknown = by && is_removed(g, TextCodec::digest(hosts_[*by].rollout.loaded));
    if (!off && !unknown && hosts_[g].rollout.agreed_to != next.mod)
      broken_ = "a description comes into force to which not all have agreed";
  }
}

bool World::described_on_wire(std::size_t g) const {
  const RolloutSide& side = hosts_[g].rollout;
  if (side.open) return side.dead_from == 0 || real() < side.dead_from + kInQueue;
  return side.closed != 0 && real() < side.closed + kInQueue;
}

/// One description on a shared network.
void World::check_descriptions() {
  std::set<std::uint8_t> used;
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    if (described_on_wire(g)) used.insert(hosts_[g].rollout.of);
    for (const auto& [admission, gate] : hosts_[g].gates)
      if (on_wire(g, gate)) used.insert(gate.description);
  }
  if (used.size() > 1) broken_ = "two descriptions are used on a shared network";
}

/// When all is well, one description is in force for all, and each rollout has its answer.
void World::check_rollouts() {
  if (!rolls_out() || !broken_.empty()) return;
  if (store_.mod(keys_->next()) != 0) broken_ = "a proposal does not end";
  const auto current = kRecords.current(store_.entries.at(keys_->current()).value);
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    const RolloutSide& side = hosts_[g].rollout;
    if (!runs(g) || is_removed(g)) continue;
    if (TextCodec::digest(side.loaded) != current->digest) broken_ = "not all have one description";
    if (!side.open) broken_ = "what the description in force promises is closed";
    if (side.state == RolloutSide::State::open || side.state == RolloutSide::State::switching)
      broken_ = "a rollout has no answer";
  }
}

/// An operator has a gateway that stays away called off.
void World::call_off_who_is_gone() {
  if (!scenario_->off_for_good) return;
  Order order;
  for (std::size_t g = hosts_.size(); g-- > 0;)
    if (hosts_[g].member)
      order.gateway = g;
    else
      order.off.push_back(keys_->gateway_name(g));
  const auto& current = hosts_[order.gateway].member->view().records().current.value;
  if (order.off.empty() || !current || current->open) return;
  order.description = current->digest[0];
  if (may_order(order)) roll_out(order);
}

// --- wrong protocols -----------------------------------------------------------------------------

void World::mutate_rollout(Txn& txn) const {
  const auto current = std::ranges::find(txn.puts, keys_->current(), &Put::key);
  if (current == txn.puts.end()) return;
  auto value = *kRecords.current(current->value);
  switch (scenario_->mutant) {
    case Mutant::counted_without_vote:
      std::erase_if(txn.compares, [](const Compare& c) { return c.key.starts_with("d/vote/"); });
      return;
    case Mutant::open_at_once:
      value.open = true;
      break;
    case Mutant::off_ignored:
      for (std::size_t g = 0; g < hosts_.size(); ++g)
        if (std::ranges::find(value.waits, keys_->gateway_name(g)) == value.waits.end())
          value.waits.push_back(keys_->gateway_name(g));
      break;
    default:
      return;
  }
  current->value = kRecords.write(value);
}

/// What a gateway that is wrong takes for seen.
void World::mutate_seen(std::size_t g, Batch& batch) const {
  const auto find = [&](const std::string& key) {
    const auto it = std::ranges::find(batch.entries, key, &Entry::key);
    return it == batch.entries.end() || it->gone ? nullptr : &*it;
  };
  std::vector<Entry> more;
  const auto add = [&](const std::string& key, const std::string& value) {
    more.push_back({.key = key, .value = value, .create = 1, .mod = batch.revision});
  };
  for (std::size_t other = 0; other < hosts_.size(); ++other) {
    if (other == g) continue;
    if (const Entry* next = find(keys_->next());
        next != nullptr && scenario_->mutant == Mutant::counted_without_vote)
      add(keys_->rollout_vote(other),
          kRecords.write(RolloutVote{.next = next->mod, .ok = true, .reason = {}}));
    if (const Entry* next = find(keys_->next());
        next != nullptr && scenario_->mutant == Mutant::former_vote_counts)
      if (const auto vote = store_.entries.find(keys_->rollout_vote(other));
          vote != store_.entries.end()) {
        auto value = *kRecords.rollout_vote(vote->second.value);
        value.next = next->mod;
        more.push_back(vote->second);
        more.back().value = kRecords.write(value);
      }
    const Entry* current = find(keys_->current());
    if (current == nullptr || scenario_->mutant != Mutant::opened_before_all) continue;
    const auto to = *kRecords.current(current->value);
    add(keys_->member(other), kRecords.write(Beat{.incarnation = 1,
                                                  .digest = to.digest,
                                                  .generation = to.generation,
                                                  .applied = batch.revision,
                                                  .lease = kLease}));
  }
  batch.entries.insert(batch.entries.end(), more.begin(), more.end());
}

}  // namespace mlcca::core::cluster::test
