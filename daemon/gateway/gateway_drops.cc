// SPDX-License-Identifier: BSD-2-Clause
// What the gates drop, and who hears of it.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
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
  for (const core::Decision& decision : state_->decisions()) {
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
  const auto& all = state_->decisions();
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
    rules_of.push_back(core::gate_state(state_->system(), state_->members(), *v, self_));
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
      if (excess && mention) tell_excess(users[rule.entry], *excess);
      dropped += drops_.look({rule.entry, Drop::misfit}, misfits(frames), now).value_or(0);
      would_drop += drops_.look({rule.entry, Drop::would_be_misfit}, would_be_misfits(frames), now)
                        .value_or(0);
    }
    if (!mention) continue;
    if (dropped != 0) tell_dropped(*v, Fate::dropped, dropped);
    if (would_drop != 0) tell_dropped(*v, Fate::let_through, would_drop);
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
    tell(Kind::dropping, 4,
         dropped_line(fate, *fresh,
                      fmt::format("without a known subject on {} ({})", ports_.interface_name(port),
                                  network)),
         network);
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

void Gateway::tell_dropped(const core::Verdict& v, Fate fate, std::uint64_t frames) {
  const core::EventChannel& c = state_->system().channels[v.channel];
  const core::Publisher& publisher = state_->members().publisher(v.publisher);
  const std::string which = v.granted ? fmt::format("that named {} ({}) and differ from the grant",
                                                    c.name, core::format_subject(c.subject))
                                      : "of " + verdict_line(*state_, v);
  tell({Kind::dropping,
        4,
        dropped_line(fate, frames, which),
        c.subject,
        c.name,
        core::name_of(state_->system(), publisher.place),
        {},
        {}});
}

/// The owner of the publisher hears of it, as does everybody who watches.
void Gateway::tell_excess(const std::vector<const core::Verdict*>& verdicts, std::uint64_t frames) {
  const core::Verdict& first = *verdicts.front();
  const core::EventChannel& channel = state_->system().channels[first.channel];
  std::vector<std::string> who;
  std::vector<core::AdmissionId> ids;
  for (const core::Verdict* v : verdicts) {
    const std::string& name = state_->members().publisher(v->publisher).name;
    if (std::ranges::find(who, name) == who.end()) who.push_back(name);
    std::ranges::copy(admissions_of(*v), std::back_inserter(ids));
  }
  std::ranges::sort(ids);
  const auto twice = std::ranges::unique(ids);
  ids.erase(twice.begin(), twice.end());
  const core::Publisher& publisher = state_->members().publisher(first.publisher);
  const AttributeSet& said = core::attributes_in(publisher, first.set);
  const Attribute what = said.has(Attribute::period) ? Attribute::period : Attribute::bandwidth;
  tell({Kind::excess, 4,
        fmt::format("{} sent {} frames of {} ({}) more than was admitted: {} said {} {}",
                    fmt::join(who, " or "), frames, channel.name,
                    core::format_subject(channel.subject), who.size() > 1 ? who.front() : "it",
                    info(what).name, core::format_value(what, said[what])),
        channel.subject, channel.name, core::name_of(state_->system(), first.to),
        core::name_of(state_->system(), publisher.place), ids});
}

}  // namespace mlcca
