// SPDX-License-Identifier: BSD-2-Clause
// What can happen in a world, and what it does.
#include <algorithm>

#include "mlcca/arithmetic.hpp"
#include "tests/core/cluster/world.hpp"

namespace mlcca::core::cluster::test {

std::string text_of(const Step& step) {
  constexpr std::array kNames = {"time",      "beats",       "apply",   "answer",  "watch",
                                 "read all",  "want",        "release", "replace", "change of mind",
                                 "drain",     "roll out",    "cancel",  "judge",   "load",
                                 "object",    "cannot load", "late",    "lose",    "lose silently",
                                 "done late", "again",       "stall",   "unstall", "pause",
                                 "resume",    "crash",       "restart", "fence",   "compact",
                                 "outage",    "outage ends", "restore"};
  return std::string(kNames[static_cast<std::size_t>(step.kind)]) + ' ' +
         std::to_string(step.gateway) +
         (step.index == 0 ? std::string() : '/' + std::to_string(step.index));
}

/// Nothing but beats is under way.
bool World::beats_only() const {
  return std::ranges::all_of(hosts_, [&](const Host& host) {
    const bool read = host.stalled || !host.synced || host.seen == store_.log.size();
    const bool beat = !host.flight || (host.flight->beat && !host.flight->result);
    return !host.member || host.paused || (read && host.synced && beat);
  });
}

std::vector<Step> World::steps(bool faults) const {
  std::vector<Step> all;
  const bool only_beats = up_ && beats_only();
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    const Host& host = hosts_[g];
    if (!runs(g)) continue;
    if (!host.synced) {
      if (up_ && !host.stalled) all.push_back({.kind = Step::Kind::read_all, .gateway = g});
    } else if (host.seen < store_.log.size() && !host.stalled && up_) {
      all.push_back({.kind = Step::Kind::watch, .gateway = g});
    }
    if (!host.flight) continue;
    if (host.flight->result)
      all.push_back({.kind = Step::Kind::answer, .gateway = g});
    else if (only_beats && all.empty())
      all.push_back({.kind = Step::Kind::beats, .gateway = g});
    else if (!only_beats && up_)
      all.push_back({.kind = Step::Kind::apply, .gateway = g});
  }
  // Before anything was asked for, one time is like another.
  const bool begun =
      !faults || scenario_->elect || has_begun_rollout() ||
      std::ranges::any_of(hosts_, [](const Host& host) { return !host.answers.empty(); });
  if (all.empty() && !at_end() && begun) all.push_back({.kind = Step::Kind::time});
  for (std::size_t g = 0; g < hosts_.size(); ++g) {
    if (!runs(g)) continue;
    if (wants_[g] > 0 && fits(g) && hosts_[g].member->why_not(clock(g)).empty())
      all.push_back({.kind = Step::Kind::want, .gateway = g});
    if (releases_ > 0 && !hosts_[g].held.empty())
      all.push_back({.kind = Step::Kind::release, .gateway = g});
    if (may_replace(g)) all.push_back({.kind = Step::Kind::replace, .gateway = g});
    if (refusals_ > 0 && !hosts_[g].agreed.empty() && are_all_kept())
      all.push_back({.kind = Step::Kind::change_mind, .gateway = g});
  }
  add_rollout_steps(all);
  if (faults) add_faults(all);
  return all;
}

void World::add_faults(std::vector<Step>& all) const {
  using enum Step::Kind;
  for (const std::size_t g : scenario_->faulty) {
    const Host& host = hosts_[g];
    const auto add = [&](int left, bool can, Step::Kind kind) {
      if (left > 0 && can) all.push_back({.kind = kind, .gateway = g});
    };
    const bool flies = host.flight && runs(g);
    add(drains_, runs(g) && !host.drained, drain);
    add(lates_, flies && !host.flight->result, Step::Kind::late);
    add(lost_, flies, lose);
    add(lost_, flies && host.flight->result, lose_silently);
    add(twice_, host.former && runs(g), again);
    add(stalls_, runs(g) && host.synced && !host.stalled, stall);
    add(1, host.stalled && runs(g), unstall);
    add(pauses_, runs(g), pause);
    add(1, host.paused, resume);
    add(crashes_, host.member.has_value(), crash);
    add(1, !host.member, restart);
    add(objections_, runs(g) && host.rollout.to_judge, object);
    add(cannots_, runs(g) && host.rollout.following.wanted, cannot_load);
    add(fences_, true, fence);
    add(compactions_, runs(g) && host.synced, compact);
  }
  if (up_)
    for (std::size_t n = 0; n < late_.size(); ++n)
      all.push_back({.kind = done_late, .gateway = late_[n].gateway, .index = n});
  if (outages_ > 0 && up_) all.push_back({.kind = outage});
  if (!up_) all.push_back({.kind = outage_ends});
  if (restores_ > 0 && !up_ && (now_ - down_since_) * kStep >= kLease + kQueued)
    all.push_back({.kind = restore});
}

/// What all have read is forgotten.
void World::forget() {
  std::size_t least = store_.log.size();
  for (const Host& host : hosts_)
    if (host.member && host.synced) least = std::min(least, host.seen);
  store_.log.erase(store_.log.begin(), store_.log.begin() + static_cast<std::ptrdiff_t>(least));
  for (Host& host : hosts_) host.seen = sub_floor(host.seen, least);
}

void World::take(const Step& step) {
  Host& host = hosts_[step.gateway];
  const std::size_t g = step.gateway;
  switch (step.kind) {
    case Step::Kind::time:
      pass_time();
      break;
    case Step::Kind::beats: {
      const TxnResult result = do_txn(host.flight->txn);
      host.flight.reset();
      deliver(g, result);
      for (std::size_t other = 0; other < hosts_.size(); ++other)
        while (runs(other) && hosts_[other].synced && !hosts_[other].stalled &&
               hosts_[other].seen < store_.log.size())
          watch(other);
      break;
    }
    case Step::Kind::apply:
      host.flight->result = do_txn(host.flight->txn);
      break;
    case Step::Kind::answer: {
      const TxnResult result = *host.flight->result;
      host.flight.reset();
      if (twice_ > 0) host.former = result;
      deliver(g, result);
      break;
    }
    case Step::Kind::watch:
      watch(g);
      break;
    case Step::Kind::read_all:
      read_all(g);
      break;
    case Step::Kind::want:
      --wants_[g];
      if (serves(g)) want_subscriber(g, host.next_id);
      ask(g, host.next_id++, way_of(g));
      turn(g);
      break;
    case Step::Kind::release: {
      --releases_;
      const std::uint64_t id = *host.held.begin();
      if (serves(g)) forget_subscriber(g, id);
      if (scenario_->subscribers != 0 && g == 0) {
        end_publisher(g);
        turn(g);
        break;
      }
      close(g, {g, id});
      host.held.erase(id);
      continued_.erase({g, id});
      vote_as(g, id, false);
      host.member->release(id, clock(g));
      turn(g);
      break;
    }
    case Step::Kind::replace:
      replace(g);
      turn(g);
      break;
    case Step::Kind::drain:
      --drains_;
      host.drained = true;
      for (auto& [admission, gate] : host.gates) close_gate(g, gate);
      close_gate(g, host.ways);
      host.held.clear();
      host.member->drain(clock(g));
      turn(g);
      break;
    case Step::Kind::change_mind: {
      --refusals_;
      const Origin origin = host.agreed.begin()->first;
      close(g, {origin.gateway, origin.id});
      host.member->vote(origin, {.ok = false, .hop = {}, .reason = "no"}, clock(g));
      turn(g);
      break;
    }
    case Step::Kind::roll_out:
    case Step::Kind::cancel:
    case Step::Kind::judge:
    case Step::Kind::load:
    case Step::Kind::object:
    case Step::Kind::cannot_load:
      take_rollout(step);
      break;
    default:
      take_fault(step);
      break;
  }
  forget();
  check();
}

void World::take_fault(const Step& step) {
  using enum Step::Kind;
  const std::size_t g = step.gateway;
  Host& host = hosts_[g];
  const auto to_late = [&] {
    if (host.flight && !host.flight->result)
      late_.push_back({.gateway = g, .process = host.process, .txn = host.flight->txn});
    host.flight.reset();
  };
  switch (step.kind) {
    case late:
      --lates_;
      if (scenario_->mutant == Mutant::renewed_without_quorum && host.flight->beat) {
        const TxnResult result{.id = host.flight->txn.id,
                               .outcome = Outcome::committed,
                               .revision = store_.revision,
                               .read = {},
                               .why = {}};
        host.flight.reset();
        deliver(g, result);
        break;
      }
      to_late();
      break;
    case lose: {
      --lost_;
      const std::uint64_t id = host.flight->txn.id;
      to_late();
      deliver(g, {.id = id, .outcome = Outcome::unsure, .read = {}, .why = {}});
      break;
    }
    case lose_silently:
      --lost_;
      host.flight.reset();
      break;
    case done_late: {
      const Late one = late_[step.index];
      late_.erase(late_.begin() + static_cast<std::ptrdiff_t>(step.index));
      const TxnResult result = do_txn(one.txn);
      if (one.process == host.process && runs(g)) deliver(g, result);
      break;
    }
    case again: {
      --twice_;
      const TxnResult result = *host.former;
      host.former.reset();
      deliver(g, result);
      break;
    }
    case stall:
      --stalls_;
      host.stalled = true;
      break;
    case unstall:
      host.stalled = false;
      break;
    case pause:
      --pauses_;
      host.paused = true;
      stop_process(g);
      break;
    case resume:
      host.paused = false;
      go_on(g);
      host.member->on_time(clock(g));
      turn(g);
      break;
    case crash:
      --crashes_;
      if (lates_ > 0) to_late();
      stop_process(g);
      host.member.reset();
      // Who asked is told nothing any more.
      std::erase_if(host.answers, [](const auto& entry) { return entry.second == 0; });
      host.paused = host.stalled = host.synced = false;
      break;
    case restart:
      start(g);
      break;
    case fence:
      --fences_;
      store_.write({{.key = keys_->fence(g), .value = "hostile"}});
      break;
    case compact:
      --compactions_;
      host.synced = false;
      break;
    case outage:
      --outages_;
      up_ = false;
      down_since_ = now_;
      break;
    case outage_ends:
      up_ = true;
      break;
    case restore: {
      --restores_;
      up_ = true;
      store_ = backup_;
      store_.write({{.key = keys_->epoch(), .value = "n"}});
      for (Host& each : hosts_) each.synced = false;
      break;
    }
    default:
      break;
  }
}

}  // namespace mlcca::core::cluster::test
