// SPDX-License-Identifier: BSD-2-Clause
// What the gates drop, and who hears of it.
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/gateway.hpp"
#include "daemon/gateway/report.hpp"

namespace mlcca {
namespace {

/// Channels that are looked at in a round: the daemon has other things to do.
constexpr std::size_t kLookedAt = 8192;

/// Counters are read while the gate counts on.
std::uint64_t misfits(const Frames& frames) {
  return frames.dropped - std::min(frames.dropped, frames.excess_dropped);
}

std::uint64_t would_be_misfits(const Frames& frames) {
  return frames.would_drop - std::min(frames.would_drop, frames.would_exceed);
}

}  // namespace

void Gateway::look_at_drops(bool mention) {
  for (const core::Decision& decision : scene_.state->decisions()) {
    look_at_drops_of(decision, mention);
    pulse();
  }
  look_at_all_unknown(mention);
  drops_.end_round();
  looked_at_ = 0;
}

/// The next one each time, and so many in a round; of all that are refused somebody hears when it
/// has gone through all of them.
bool Gateway::look_at_some_drops() {
  const auto& all = scene_.state->decisions();
  if (looked_at_ < all.size()) look_at_drops_of(all[looked_at_++], true);
  if (looked_at_ >= all.size()) {
    looked_at_ = 0;
    drops_.end_round();
    return false;
  }
  return looked_at_ % kLookedAt != 0;
}

/// Of each entry once, with the first of the verdicts whose events come or leave by it; granted
/// ones before others.
void Gateway::look_at_drops_of(const core::Decision& decision, bool mention) {
  std::vector<const core::Verdict*> verdicts;
  verdicts.reserve(decision.verdicts.size());
  for (const core::Verdict& v : decision.verdicts) verdicts.push_back(&v);
  std::ranges::stable_partition(verdicts, &core::Verdict::granted);
  std::map<core::GateEntry, std::vector<const core::Verdict*>> users;
  std::map<const core::Verdict*, core::GateState> first_to_use;
  std::vector<core::GateState> rules_of;
  rules_of.reserve(verdicts.size());
  for (const core::Verdict* v : verdicts) {
    rules_of.push_back(
        core::gate_state(scene_.state->system(), scene_.state->members(), *v, scene_.self));
    for (const core::GateRule& rule : rules_of.back()) {
      auto& of_entry = users[rule.entry];
      if (of_entry.empty()) first_to_use[v].push_back(rule);
      of_entry.push_back(v);
    }
  }
  const std::int64_t now = monotonic_s();
  for (const auto& [v, rules] : first_to_use) {
    std::uint64_t dropped = 0;
    std::uint64_t would_drop = 0;
    for (const core::GateRule& rule : rules) {
      const Frames frames = ports_.frames({rule});
      const auto excess = drops_.look({rule.entry, Drop::excess}, frames.excess, now);
      if (excess && mention) deliveries_.excess(users[rule.entry], *excess);
      dropped += drops_.look({rule.entry, Drop::misfit}, misfits(frames), now).value_or(0);
      would_drop += drops_.look({rule.entry, Drop::would_be_misfit}, would_be_misfits(frames), now)
                        .value_or(0);
    }
    if (!mention) continue;
    if (dropped != 0) deliveries_.dropped(*v, Fate::dropped, dropped);
    if (would_drop != 0) deliveries_.dropped(*v, Fate::let_through, would_drop);
  }
  if (verdicts.empty()) return;
  const std::size_t channel = verdicts.front()->channel;
  const auto shared = shared_entries_of(channel);
  // Granted ones come first.
  bool troubled = false;
  for (std::size_t i = 0; i < verdicts.size() && verdicts[i]->granted && !troubled; ++i)
    troubled = !troubles_of(*verdicts[i], rules_of[i], shared, ports_.watch(rules_of[i])).empty();
  if (troubled)
    troubled_.insert(channel);
  else
    troubled_.erase(channel);
}

void Gateway::look_at_unknown(std::size_t port, bool mention) {
  const UnknownFrames frames = ports_.unknown_frames(port);
  const auto look = [&](Fate fate, std::uint64_t counted) {
    const auto fresh = unknown_.look({port, fate}, counted, monotonic_s());
    if (!fresh || !mention) return;
    const std::string& network = ports_.network_of(port);
    log_.warning(Kind::dropping,
                 dropped_line(fate, *fresh,
                              fmt::format("without a known subject on {} ({})",
                                          ports_.interface_name(port), network)),
                 {.network = network});
  };
  look(Fate::dropped, frames.dropped);
  look(Fate::let_through, frames.would_drop);
}

void Gateway::look_at_all_unknown(bool mention) {
  for (std::size_t p = 0; p < ports_.size(); ++p) look_at_unknown(p, mention);
  unknown_.end_round();
  at_unknown_ = 0;
}

bool Gateway::look_at_next_unknown() {
  if (at_unknown_ < ports_.size()) {
    look_at_unknown(at_unknown_++, true);
    return true;
  }
  unknown_.end_round();
  at_unknown_ = 0;
  return unknown_.tidy();
}

/// What came so far is told as what became of it.
void Gateway::tell_all_drops() {
  drops_.wake();
  unknown_.wake();
  look_at_drops(true);
}

/// What is counted now was told, or is by a name that may mean something else.
void Gateway::forget_drops() {
  drops_.forget();
  troubled_.clear();
  unknown_.forget();
  look_at_drops(false);
}

}  // namespace mlcca
