// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/drop_reports.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

namespace mlcca {
namespace {

/// Channels that are polled in one round, so that a round stays short.
constexpr std::size_t kChannelsOfRound = 8192;

/// The gate counts on while its counters are read, so the parts may exceed the sum.
std::uint64_t misfits(const Frames& frames) {
  return frames.dropped - std::min(frames.dropped, frames.excess_dropped);
}

std::uint64_t would_be_misfits(const Frames& frames) {
  return frames.would_drop - std::min(frames.would_drop, frames.would_exceed);
}

std::uint64_t counted(const Frames& frames, Drop reason) {
  switch (reason) {
    case Drop::misfit:
      return misfits(frames);
    case Drop::would_be_misfit:
      return would_be_misfits(frames);
    case Drop::excess:
      return frames.excess - std::min(frames.excess, frames.would_exceed);
    case Drop::would_exceed:
      return frames.would_exceed;
  }
  return 0;
}

}  // namespace

/// Polls the next channel. Refused deliveries are reported when all channels have been polled.
bool DropReports::poll_some_channels() {
  const auto& all = scene_.state->decisions();
  if (next_channel_ == 0) begin_round();
  if (next_channel_ < all.size()) poll(all[next_channel_++], Reporting::yes);
  if (next_channel_ >= all.size()) {
    next_channel_ = 0;
    of_entries_.end_round();
    return false;
  }
  return next_channel_ % kChannelsOfRound != 0;
}

bool DropReports::poll_some_ports() {
  if (next_port_ < gates_.size()) {
    poll_unknown(next_port_++, Reporting::yes);
    return true;
  }
  of_ports_.end_round();
  next_port_ = 0;
  return of_ports_.tidy();
}

void DropReports::poll_all(Reporting reporting) {
  // A round that has begun continues: some of its channels were not sampled yet.
  if (next_channel_ == 0) begin_round();
  for (const core::Decision& decision : scene_.state->decisions()) {
    poll(decision, reporting);
    pulse_();
  }
  for (std::size_t p = 0; p < gates_.size(); ++p) poll_unknown(p, reporting);
  of_ports_.end_round();
  next_port_ = 0;
  of_entries_.end_round();
  next_channel_ = 0;
}

void DropReports::report_all() {
  of_entries_.wake();
  of_ports_.wake();
  poll_all(Reporting::yes);
}

void DropReports::forget() {
  audit_.restart_clean();
  of_entries_.forget();
  of_ports_.forget();
  next_channel_ = 0;
  poll_all(Reporting::no);
  // After the counters of the slots: what is not in their starting points has its cause in these.
  causes_.forget();
  causes_.begin_round();
  senders_.forget();
}

void DropReports::sample_entry(const core::GateRule& rule,
                               const std::vector<const core::Verdict*>& users, Reporting reporting,
                               Dropped& sum) {
  const Frames frames = gates_.frames({rule});
  const core::Verdict& user = *users.front();
  const auto excess = sample(rule.entry, Drop::excess, user, frames);
  if (excess && reporting == Reporting::yes) deliveries_.excess(users, Fate::dropped, *excess);
  const auto passed = sample(rule.entry, Drop::would_exceed, user, frames);
  if (passed && reporting == Reporting::yes) deliveries_.excess(users, Fate::passed, *passed);
  sum.dropped += sample(rule.entry, Drop::misfit, user, frames).value_or(0);
  sum.would_drop += sample(rule.entry, Drop::would_be_misfit, user, frames).value_or(0);
}

/// Excess that the port lets pass is reported, but is no finding, because nothing would have been
/// dropped.
std::optional<std::uint64_t> DropReports::sample(const core::GateEntry& entry, Drop reason,
                                                 const core::Verdict& user, const Frames& frames) {
  const auto mention =
      of_entries_.sample({entry, reason}, counted(frames, reason), clock_.monotonic_s());
  const std::uint64_t grown = of_entries_.grown();
  const bool is_excess = reason == Drop::excess || reason == Drop::would_exceed;
  if (grown == 0 || (reason == Drop::excess && frames.excess_dropped == 0)) return mention;
  const bool passed = reason == Drop::would_be_misfit || reason == Drop::would_exceed;
  const Fate fate = passed ? Fate::passed : Fate::dropped;
  if (is_excess) {
    audit_.refused(user, entry, {core::FrameReason::excess}, fate, grown);
    return mention;
  }
  note_misfits(entry, user, fate, grown, frames.last_reason);
  return mention;
}

void DropReports::note_misfits(const core::GateEntry& entry, const core::Verdict& user, Fate fate,
                               std::uint64_t frames, std::optional<core::FrameReason> latest) {
  for (const MisfitSenders::Sent& sent : senders_.of(entry, frames)) {
    causes_.explain(entry, fate, sent.sender.reason, sent.frames);
    audit_.refused(user, entry, sent.sender, fate, sent.frames, span_);
    frames -= sent.frames;
  }
  if (frames == 0) return;
  for (const auto& cause : causes_.of(entry, fate, frames, latest))
    audit_.refused(user, entry, cause.reason, fate, cause.frames);
}

void DropReports::begin_round() {
  const std::uint64_t now = clock_.monotonic_ns();
  span_ = round_began_ == 0 ? 0 : now - round_began_;
  round_began_ = now;
  causes_.begin_round();
  senders_.begin_round();
}

bool DropReports::goes_elsewhere(const core::Verdict& verdict) const {
  const core::State& state = *scene_.state;
  return core::goes_elsewhere(
      verdict, core::gate_state(state.system(), state.members(), verdict, scene_.self));
}

void DropReports::verdicts_changed(const core::DecisionChange& change) {
  const core::State& state = *scene_.state;
  Dropped sum;
  std::set<core::GateEntry> seen;
  for (const core::Verdict& v : state.decisions()[change.channel].verdicts) {
    const core::Verdict* const old = core::same_delivery(change.before, v);
    const bool was_elsewhere = old != nullptr && old->granted && goes_elsewhere(*old);
    if (!v.granted || (old != nullptr && old->granted && !was_elsewhere)) continue;
    for (const core::GateRule& rule :
         core::gate_state(state.system(), state.members(), v, scene_.self)) {
      if (!seen.insert(rule.entry).second) continue;
      const Dropped before = pass_over(rule);
      if (was_elsewhere) continue;
      sum.dropped += before.dropped;
      sum.would_drop += before.would_drop;
    }
  }
  if (sum.dropped != 0) deliveries_.dropped_before(change.channel, Fate::dropped, sum.dropped);
  if (sum.would_drop != 0) deliveries_.dropped_before(change.channel, Fate::passed, sum.would_drop);
}

/// Reports nothing of the frames that an entry has dropped so far: another gateway forwards them.
DropReports::Dropped DropReports::pass_over(const core::GateRule& rule) {
  const Frames frames = gates_.frames({rule});
  const auto close = [&](Drop reason, std::uint64_t counted) {
    const std::uint64_t fresh =
        of_entries_.close({rule.entry, reason}, counted, clock_.monotonic_s());
    // Their senders have nothing to do with what is dropped from now on.
    if (of_entries_.grown() != 0) static_cast<void>(senders_.of(rule.entry, of_entries_.grown()));
    return fresh;
  };
  return {.dropped = close(Drop::misfit, misfits(frames)),
          .would_drop = close(Drop::would_be_misfit, would_be_misfits(frames))};
}

/// Passes over the entries that only deliveries over other gateways use.
void DropReports::pass_over_elsewhere(const Polled& polled, const Users& users) {
  for (std::size_t i = 0; i < polled.verdicts.size(); ++i) {
    if (!core::goes_elsewhere(*polled.verdicts[i], polled.rules[i])) continue;
    for (const core::GateRule& rule : polled.rules[i])
      if (!users.contains(rule.entry)) pass_over(rule);
  }
}

/// Samples each entry once, for the first verdict whose events come or leave by it; granted
/// verdicts come first.
void DropReports::poll(const core::Decision& decision, Reporting reporting) {
  Polled polled;
  polled.verdicts.reserve(decision.verdicts.size());
  for (const core::Verdict& v : decision.verdicts) polled.verdicts.push_back(&v);
  std::ranges::stable_partition(polled.verdicts, &core::Verdict::granted);
  Users users;
  std::map<const core::Verdict*, core::GateState> first_to_use;
  polled.rules.reserve(polled.verdicts.size());
  for (const core::Verdict* v : polled.verdicts) {
    polled.rules.push_back(
        core::gate_state(scene_.state->system(), scene_.state->members(), *v, scene_.self));
    if (core::goes_elsewhere(*v, polled.rules.back())) continue;
    for (const core::GateRule& rule : polled.rules.back()) {
      auto& of_entry = users[rule.entry];
      if (of_entry.empty()) first_to_use[v].push_back(rule);
      of_entry.push_back(v);
    }
  }
  pass_over_elsewhere(polled, users);
  for (const auto& [v, rules] : first_to_use) {
    Dropped sum;
    for (const core::GateRule& rule : rules) sample_entry(rule, users[rule.entry], reporting, sum);
    if (reporting == Reporting::no) continue;
    if (sum.dropped != 0) deliveries_.dropped(*v, Fate::dropped, sum.dropped);
    if (sum.would_drop != 0) deliveries_.dropped(*v, Fate::passed, sum.would_drop);
  }
  if (!polled.verdicts.empty()) on_polled_(polled);
}

void DropReports::poll_unknown(std::size_t port, Reporting reporting) {
  const UnknownFrames frames = gates_.unknown_frames(port);
  if (reporting == Reporting::yes)
    audit_.poll(port, frames);
  else
    audit_.take_up(port, frames);
  const auto poll = [&](Fate fate, std::uint64_t counted) {
    const auto fresh = of_ports_.sample({port, fate}, counted, clock_.monotonic_s());
    if (!fresh || reporting == Reporting::no) return;
    const std::string& network = gates_.network_of(port);
    log_.warning(Kind::dropped,
                 dropped_line(fate, *fresh,
                              fmt::format("without a known subject on {} ({})",
                                          gates_.interface_name(port), network)),
                 {.network = network, .frames = *fresh});
  };
  poll(Fate::dropped, frames.dropped);
  poll(Fate::passed, frames.would_drop);
}

}  // namespace mlcca
