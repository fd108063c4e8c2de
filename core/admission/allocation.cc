// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/allocation.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/model/progress.hpp"

namespace mlcca::core {

void Allocation::sort(std::vector<std::size_t>& channels) const {
  std::ranges::sort(channels, {}, [this](std::size_t c) {
    Progress::step();
    return std::tuple(-int{importance(c)}, ages_.empty() ? 0 : ages_[c], c);
  });
}

void Allocation::take_out(std::size_t channel) {
  for (const std::size_t p : s_.members.publishers_of(channel)) ledger_.remove(p);
  Progress::step();
}

void Allocation::put(std::size_t channel, Decision decision) {
  if (former_ != nullptr) former_->try_emplace(channel, std::move(decisions_[channel]));
  // A decision is stored for long, so it keeps no spare memory.
  for (Verdict& v : decision.verdicts) v.rows.shrink_to_fit();
  decisions_[channel] = std::move(decision);
  Progress::step();
}

bool Allocation::is_best(std::size_t channel) const {
  const Decision& now = decisions_[channel];
  return now.set == 0 && now.granted != 0 && now.all_granted();
}

bool Allocation::keep(const std::vector<std::size_t>& channels) {
  const Ledger::Mark before = ledger_.mark();
  std::vector<std::pair<std::size_t, Decision>> kept;
  for (const std::size_t c : channels) {
    const Decision& old = decisions_[c];
    if (old.granted == 0) continue;
    const Ledger::Mark mark = ledger_.mark();
    Decision now = decide_in(s_, c, old.set, ledger_, &old);
    if (!keeps_grants(old, now)) {
      // It may not fit because its links or networks have become worse, and not because of other
      // channels.
      ledger_.roll_back(mark);
      const Decision best = alone(c);
      now = decide_in(s_, c, best.set, ledger_, &best);
      if (!keeps_grants(best, now)) {
        ledger_.roll_back(before);
        return false;
      }
    }
    kept.emplace_back(c, std::move(now));
  }
  for (auto& [c, decision] : kept) put(c, std::move(decision));
  ledger_.commit();
  return true;
}

/// What the channel could keep of its former grants, from its set downwards, if no other channel
/// held anything.
Decision Allocation::alone(std::size_t channel) {
  if (!unloaded_) unloaded_ = empty_ledger(s_.system, s_.world);
  const Decision& old = decisions_[channel];
  Decision most;
  for (std::size_t set = old.set; set < sets_of(s_.system, channel); ++set) {
    const Ledger::Mark mark = unloaded_->mark();
    Decision now = decide_in(s_, channel, set, *unloaded_, &old);
    unloaded_->roll_back(mark);
    if (keeps_grants(old, now)) return now;
    if (set == old.set || now.granted > most.granted) most = std::move(now);
  }
  return most;
}

/// The channel in the lowest set in which all grants of `before` hold; nullopt if there is none.
std::optional<Decision> Allocation::lowered(std::size_t channel, const Decision& before) {
  for (std::size_t set = sets_of(s_.system, channel); set-- > 0;) {
    const Ledger::Mark mark = ledger_.mark();
    Decision now = decide_in(s_, channel, set, ledger_, &before);
    if (keeps_grants(before, now)) return now;
    ledger_.roll_back(mark);
  }
  return std::nullopt;
}

void Allocation::degrade(const std::vector<std::size_t>& channels) {
  for (const std::size_t c : channels) {
    if (decisions_[c].granted == 0) continue;
    const Decision before = decisions_[c];
    if (auto now = lowered(c, before)) {
      put(c, std::move(*now));
      continue;
    }
    put(c, {});
    // If no set keeps all grants, the set with the most grants is chosen.
    std::optional<std::size_t> chosen;
    std::size_t most = 0;
    for (std::size_t set = sets_of(s_.system, c); set-- > 0;) {
      const Ledger::Mark mark = ledger_.mark();
      const Decision now = decide_in(s_, c, set, ledger_, &before);
      ledger_.roll_back(mark);
      if (now.granted <= most) continue;
      most = now.granted;
      chosen = set;
    }
    if (chosen) put(c, decide_in(s_, c, *chosen, ledger_, &before));
  }
  ledger_.commit();
}

/// Whether a delivery is granted over another route than before.
bool Allocation::takes_another_way(const Decision& before, const Decision& after) {
  return std::ranges::any_of(after.verdicts, [&](const Verdict& v) {
    const Verdict* old = same_delivery(before, v);
    return v.granted && old != nullptr && old->granted && v.route != old->route;
  });
}

bool Allocation::step_up(std::size_t channel) {
  Progress::step();
  if (is_best(channel)) return false;
  const Decision& now = decisions_[channel];
  // A waiting delivery may be served in a lower set than the one in use: service comes before
  // quality within a channel, too.
  const bool whole = now.granted != 0 && now.all_granted();
  for (std::size_t set = whole ? now.set : sets_of(s_.system, channel); set-- > 0;) {
    const Ledger::Mark mark = ledger_.mark();
    take_out(channel);
    Decision next = decide_in(s_, channel, set, ledger_);
    const bool keeps = keeps_grants(now, next);
    const bool more = next.granted > now.granted;
    const bool better = next.granted == now.granted && set < now.set && now.granted != 0;
    const bool same = next.granted == now.granted && set == now.set && now.granted != 0;
    if (keeps && (more || better || same)) {
      const bool moves = takes_another_way(now, next);
      put(channel, std::move(next));
      ledger_.commit();
      // An equal result on the same route only renews the reasons of refusals. On another route it
      // frees resources for which others may be waiting.
      if (!same || moves) return true;
      continue;
    }
    ledger_.roll_back(mark);
    // A refusal is explained with the preferred set.
    if (now.granted == 0 && set == 0) put(channel, std::move(next));
  }
  return false;
}

bool Allocation::admit_waiting(const std::vector<std::size_t>& channels) {
  bool any = false;
  for (const std::size_t c : channels)
    if (decisions_[c].granted == 0) any |= step_up(c);
  ledger_.commit();
  return any;
}

bool Allocation::upgrade(const std::vector<std::size_t>& channels) {
  bool any = false;
  for (auto begin = channels.begin(); begin != channels.end();) {
    const auto end = std::find_if(
        begin, channels.end(), [&](std::size_t c) { return importance(c) != importance(*begin); });
    // Repeats until a round over all channels has changed none, because a channel that takes
    // another route frees resources.
    for (bool progress = true; progress; any |= progress) {
      progress = false;
      for (auto it = begin; it != end; ++it)
        if (decisions_[*it].granted != 0) progress |= step_up(*it);
    }
    begin = end;
  }
  ledger_.commit();
  return any;
}

bool is_plain(const System& system) {
  return std::ranges::all_of(
      system.channels, [](const EventChannel& c) { return c.lower.empty() && c.importance == 0; });
}

void decide_each(const Situation& situation, Ledger& ledger, const EachChannel& each) {
  const std::size_t channels = situation.system.channels.size();
  if (is_plain(situation.system)) {
    for (std::size_t c = 0; c < channels; ++c) {
      const Decision decision = decide_in(situation, c, 0, ledger);
      ledger.commit();
      each(c, decision);
    }
    return;
  }
  std::vector<Decision> decisions(channels);
  std::vector<std::size_t> all(channels);
  std::iota(all.begin(), all.end(), std::size_t{0});
  decide_some(situation, std::move(all), decisions, ledger);
  for (std::size_t c = 0; c < channels; ++c) each(c, decisions[c]);
}

void decide_some(const Situation& situation, std::vector<std::size_t> channels,
                 std::vector<Decision>& decisions, Ledger& ledger) {
  for (const std::size_t c : channels) decisions[c] = {};
  Allocation allocation(situation, {}, decisions, ledger);
  allocation.sort(channels);
  while (allocation.admit_waiting(channels) || allocation.upgrade(channels)) {
  }
}

}  // namespace mlcca::core
