// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/channel_reports.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/model/text.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_size.hpp"
#include "daemon/gateway/slice_budget.hpp"

namespace mlcca {
namespace {

constexpr std::size_t kChannelRow = 1024;  // typical bytes on the wire

std::vector<std::string> gateways_on(const core::System& system, const core::Route& route) {
  std::vector<std::string> out;
  for (const core::Place& hop : route)
    if (hop.kind == core::Place::Kind::gateway) out.push_back(core::name_of(system, hop));
  return out;
}

}  // namespace

std::vector<control::Channel> ChannelReports::report(
    const std::vector<const core::Verdict*>& verdicts) const {
  std::vector<control::Channel> out;
  if (verdicts.empty()) return out;
  const auto shared = health_.shared_of(verdicts.front()->channel);
  const auto entries = core::entries_of(shared);
  for (const core::Verdict* v : verdicts) {
    const auto rules =
        core::gate_state(scene_.state->system(), scene_.state->members(), *v, scene_.self);
    control::Channel& channel = out.emplace_back(
        channel_report(*scene_.state, *v,
                       core::goes_elsewhere(*v, rules) ? Frames{} : gates_.frames(rules, entries)));
    channel.counts_shared = std::ranges::any_of(rules, [&](const core::GateRule& rule) {
      return std::ranges::find(entries, rule.entry) != entries.end();
    });
    // A refused delivery may have no rules because it has no tag yet, or no route.
    channel.crosses_no_gate = v->granted && rules.empty();
    if (!v->granted) continue;
    if (core::goes_elsewhere(*v, rules)) {
      channel.crosses_no_gate = true;
      channel.carried_by = gateways_on(scene_.state->system(), v->route);
      continue;
    }
    auto supervision = health_.supervision_of(*v, rules, shared);
    channel.problems = health_.troubles_of(*v, rules, shared, supervision);
    channel.watch = std::move(supervision.watch);
    set_not_supervised(channel, std::move(supervision.lacking));
  }
  return out;
}

control::Channels ChannelReports::known(const ParsedRequest& asked) const {
  std::vector<const core::Verdict*> known;
  for (const core::Verdict& v : scene_.state->decisions()[asked.channel].verdicts) {
    if (asked.from && scene_.state->members().publisher(v.publisher).place != *asked.from) continue;
    if (asked.to && v.to != *asked.to) continue;
    known.push_back(&v);
  }
  return {report(known)};
}

control::Channels ChannelReports::of_those(std::size_t channel, const Concerned& concerned) const {
  std::vector<const core::Verdict*> verdicts;
  for (const core::Verdict& v : scene_.state->decisions()[channel].verdicts)
    if (concerned(v)) verdicts.push_back(&v);
  control::Channels out;
  out.left_out = leave_out(*scene_.state, verdicts);
  out.channels = report(verdicts);
  return out;
}

control::Channels ChannelReports::of_publisher(std::size_t channel, std::size_t publisher) const {
  return of_those(channel,
                  [publisher](const core::Verdict& v) { return v.publisher == publisher; });
}

control::Channels ChannelReports::of_subscriber(std::size_t channel, std::size_t subscriber) const {
  return of_those(channel, [subscriber](const core::Verdict& v) {
    return std::ranges::find(v.subscribers, subscriber) != v.subscribers.end();
  });
}

control::Channels ChannelReports::of_admission(core::AdmissionId id) const {
  const auto known = scene_.state->admissions().find(id);
  if (known == scene_.state->admissions().end()) return {};
  return of_those(known->second,
                  [this, id](const core::Verdict& v) { return deliveries_.concerns(v, id); });
}

/// A delivery has as many lines as there are comparisons for it.
serve::Slice ChannelReports::some(Position& at) const {
  constexpr std::size_t lines_of_a_row = 16;
  control::Channels out;
  const auto& decisions = scene_.state->decisions();
  SliceBudget budget(kChannelRow);
  for (bool goes_on = true; goes_on && at.channel < decisions.size();) {
    const auto& verdicts = decisions[at.channel].verdicts;
    std::vector<const core::Verdict*> some;
    std::size_t lines = 0;
    for (; at.verdict < verdicts.size() && lines < control::Channel::kMostRows; ++at.verdict) {
      some.push_back(&verdicts[at.verdict]);
      lines += lines_of(*scene_.state, verdicts[at.verdict]);
    }
    std::ranges::move(report(some), std::back_inserter(out.channels));
    if (at.verdict >= verdicts.size()) at = {at.channel + 1, 0};
    goes_on = budget.made(std::max({std::size_t{1}, some.size(), lines / lines_of_a_row}));
  }
  return {{std::move(out)}, at.channel < decisions.size()};
}

}  // namespace mlcca
