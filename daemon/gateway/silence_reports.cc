// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/silence_reports.hpp"

#include <algorithm>

#include "core/gates/plan.hpp"
#include "core/model/text.hpp"

namespace mlcca {

SilenceReports::SilenceReports(sd_event* loop, const Scene& scene, const Clock& clock,
                               const GateReader& gates, DeliveryEvents& deliveries,
                               DeliveryHealth& health, ReportedSilences& reported)
    : scene_(scene),
      clock_(clock),
      gates_(gates),
      deliveries_(deliveries),
      health_(health),
      reported_(reported) {
  // If there is no timer, the rounds call poll() once a second.
  static_cast<void>(timer_.start(loop, [this] { poll(); }));
}

void SilenceReports::on_event(const core::Verdict& verdict, const gate_event& event,
                              const std::string& publishers) {
  if (event.kind == GATE_E_MISSING)
    missing(verdict, event, publishers);
  else
    restored(verdict, event, publishers);
  arm();
}

SilenceReports::Key SilenceReports::key_of(const core::Verdict& verdict) const {
  return silent_delivery(*scene_.state, verdict);
}

void SilenceReports::missing(const core::Verdict& verdict, const gate_event& event,
                             const std::string& publishers) {
  const Value longest = core::silence_of(verdict);
  if (longest == 0) return;  // no subscriber there supervises it
  if (event.silent < longest) {
    reported_.remove(verdict);  // reported for an earlier silence
    wait(key_of(verdict), clock_.monotonic_ns() + (longest - event.silent));
    return;
  }
  reported_.add(verdict);
  deliveries_.silence(verdict, event, publishers);
}

/// What a former daemon has reported is not known here, so a long silence counts as reported.
void SilenceReports::restored(const core::Verdict& verdict, const gate_event& event,
                              const std::string& publishers) {
  wait_no_more(key_of(verdict));
  const Value longest = core::silence_of(verdict);
  if (reported_.remove(verdict) || (longest != 0 && event.silent >= longest))
    deliveries_.silence(verdict, event, publishers);
}

void SilenceReports::wait(const Key& key, std::uint64_t due) {
  wait_no_more(key);
  waiting_.emplace(key, due);
  by_due_.emplace(due, key);
}

void SilenceReports::wait_no_more(const Key& key) {
  const auto known = waiting_.find(key);
  if (known == waiting_.end()) return;
  by_due_.erase({known->second, key});
  waiting_.erase(known);
}

/// Examines the deliveries of each channel once.
void SilenceReports::poll() {
  const std::uint64_t now = clock_.monotonic_ns();
  std::map<core::Subject, std::set<core::Delivery>> due;
  while (!by_due_.empty() && by_due_.begin()->first <= now) {
    const Key key = by_due_.begin()->second;
    wait_no_more(key);
    due[key.subject].insert(key.delivery);
  }
  const core::State& state = *scene_.state;
  for (const auto& [subject, deliveries] : due) {
    const auto channel = state.channel_of(subject);
    if (!channel) continue;
    for (const core::Verdict& v : state.decisions()[*channel].verdicts)
      if (v.granted && deliveries.contains(state.delivery_of(v))) examine(v);
  }
  reported_.forget_ended();
  arm();
}

/// The gate has not reported that events have come again, so the timeout may pass once more.
void SilenceReports::examine(const core::Verdict& verdict) {
  const core::State& state = *scene_.state;
  const auto watch =
      gates_.watch(core::gate_state(state.system(), state.members(), verdict, scene_.self));
  const Value longest = core::silence_of(verdict);
  if (!watch || longest == 0) return;
  if (watch->since_last_ns < longest) {
    wait(key_of(verdict), clock_.monotonic_ns() + (longest - watch->since_last_ns));
    return;
  }
  health_.note_missing(verdict.channel);
  gate_event event{};
  event.kind = GATE_E_MISSING;
  event.subject = state.system().channels[verdict.channel].subject;
  event.silent = watch->since_last_ns;
  event.never = watch->events == 0 ? 1 : 0;
  missing(verdict, event, core::names_of(state.members(), {verdict.publisher}));
}

void SilenceReports::arm() {
  if (by_due_.empty()) return;
  const std::uint64_t now = clock_.monotonic_ns();
  const std::uint64_t next = by_due_.begin()->first;
  timer_.set((next - std::min(next, now)) / 1'000 + 1);
}

}  // namespace mlcca
