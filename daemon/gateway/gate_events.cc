// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/gate_events.hpp"

#include <fmt/core.h>
#include <linux/can.h>

#include <algorithm>
#include <cstddef>

#include "core/gates/plan.hpp"
#include "core/model/text.hpp"
#include "daemon/gates/counters.hpp"

namespace mlcca {
namespace {

/// "123", "FD 1ABCDEF0", "0x44697374616e6365 on its way out"
std::string frame_name(const gate_sample& sample) {
  const char* const way = sample.direction == GATE_EGRESS ? " on its way out" : "";
  if (sample.format == 0) {
    enforce::Mac mac;
    std::ranges::copy(sample.mac, mac.begin());
    return fmt::format("{}{} from {}", core::format_subject(sample.subject), way,
                       enforce::sender_text(sample.station, mac));
  }
  const char* const remote = (sample.can_id & CAN_RTR_FLAG) != 0 ? "remote " : "";
  std::string format;
  if (sample.format == GATE_FD) format = "FD ";
  if (sample.format == GATE_XL) format = "XL ";
  return (sample.can_id & CAN_EFF_FLAG) != 0
             ? fmt::format("{}{}{:08X}{}", format, remote, sample.can_id & CAN_EFF_MASK, way)
             : fmt::format("{}{}{:03X}{}", format, remote, sample.can_id & CAN_SFF_MASK, way);
}

}  // namespace

GateEvents::GateEvents(const Parts& parts) : parts_(parts) {
  // Without a timer the rounds poll, once a second.
  static_cast<void>(timer_.start(parts_.loop, [this] { poll(); }));
}

/// An event of a slot that was given to another grant meanwhile concerns no delivery any more.
void GateEvents::on_event(const gate_event& event) {
  if (event.kind == GATE_E_BOUND) {
    parts_.tags.poll();
    return;
  }
  const core::State& state = *parts_.scene.state;
  const auto channel = state.channel_of(event.subject);
  if (!channel) return;
  std::vector<const core::Verdict*> concerned;
  std::vector<std::size_t> publishers;
  for (const core::Verdict& v : state.decisions()[*channel].verdicts)
    if (v.granted && parts_.gates.is_of(event, core::gate_state(state.system(), state.members(), v,
                                                                parts_.scene.self))) {
      concerned.push_back(&v);
      if (std::ranges::find(publishers, v.publisher) == publishers.end())
        publishers.push_back(v.publisher);
    }
  if (concerned.empty()) return;
  if (event.kind == GATE_E_MISSING) parts_.health.note_missing(*channel);
  const std::string names = core::names_of(state.members(), publishers);
  for (const core::Verdict* v : concerned)
    if (event.kind == GATE_E_MISSING)
      missing(*v, event, names);
    else
      restored(*v, event, names);
  arm();
}

// --- who waits longer ----------------------------------------------------------------------------

GateEvents::Key GateEvents::key_of(const core::Verdict& verdict) const {
  const core::State& state = *parts_.scene.state;
  return {state.system().channels[verdict.channel].subject, state.delivery_of(verdict)};
}

void GateEvents::missing(const core::Verdict& verdict, const gate_event& event,
                         const std::string& publishers) {
  const Value longest = core::silence_of(verdict);
  if (longest == 0) return;  // nobody there minds
  if (event.silent < longest) {
    reported_.erase(key_of(verdict));  // of a silence before
    wait(key_of(verdict), parts_.clock.monotonic_ns() + (longest - event.silent));
    return;
  }
  reported_.insert(key_of(verdict));
  parts_.deliveries.silence(verdict, event, publishers);
}

/// What a former daemon has reported is not known here.
void GateEvents::restored(const core::Verdict& verdict, const gate_event& event,
                          const std::string& publishers) {
  const Key key = key_of(verdict);
  wait_no_more(key);
  const Value longest = core::silence_of(verdict);
  if (reported_.erase(key) != 0 || (longest != 0 && event.silent >= longest))
    parts_.deliveries.silence(verdict, event, publishers);
}

void GateEvents::wait(const Key& key, std::uint64_t due) {
  wait_no_more(key);
  waiting_.emplace(key, due);
  by_due_.emplace(due, key);
}

void GateEvents::wait_no_more(const Key& key) {
  const auto known = waiting_.find(key);
  if (known == waiting_.end()) return;
  by_due_.erase({known->second, key});
  waiting_.erase(known);
}

/// The deliveries of a channel are gone through once.
void GateEvents::poll() {
  const std::uint64_t now = parts_.clock.monotonic_ns();
  std::map<core::Subject, std::set<core::Delivery>> due;
  while (!by_due_.empty() && by_due_.begin()->first <= now) {
    const Key key = by_due_.begin()->second;
    wait_no_more(key);
    due[key.subject].insert(key.delivery);
  }
  const core::State& state = *parts_.scene.state;
  for (const auto& [subject, deliveries] : due) {
    const auto channel = state.channel_of(subject);
    if (!channel) continue;
    for (const core::Verdict& v : state.decisions()[*channel].verdicts)
      if (v.granted && deliveries.contains(state.delivery_of(v)))
        examine({subject, state.delivery_of(v)}, v);
  }
  arm();
}

/// As long as the gate has not reported that the events come again, they may stay out once more.
void GateEvents::examine(const Key& key, const core::Verdict& verdict) {
  const core::State& state = *parts_.scene.state;
  const auto watch = parts_.gates.watch(
      core::gate_state(state.system(), state.members(), verdict, parts_.scene.self));
  const Value longest = core::silence_of(verdict);
  if (!watch || longest == 0) return;
  if (watch->since_last_ns < longest) {
    wait(key, parts_.clock.monotonic_ns() + (longest - watch->since_last_ns));
    return;
  }
  parts_.health.note_missing(verdict.channel);
  gate_event event{};
  event.kind = GATE_E_MISSING;
  event.subject = key.subject;
  event.silent = watch->since_last_ns;
  event.never = watch->events == 0 ? 1 : 0;
  missing(verdict, event, core::names_of(state.members(), {verdict.publisher}));
}

void GateEvents::arm() {
  if (by_due_.empty()) return;
  const std::uint64_t now = parts_.clock.monotonic_ns();
  const std::uint64_t next = by_due_.begin()->first;
  timer_.set((next - std::min(next, now)) / 1'000 + 1);
}

void GateEvents::on_sample(const gate_sample& sample) {
  const std::string interface = parts_.links.name_of(static_cast<int>(sample.ifindex));
  for (std::size_t p = 0; p < parts_.gates.size(); ++p) {
    if (parts_.gates.interface_name(p) != interface) continue;
    const std::string& network = parts_.gates.network_of(p);
    const UnknownFrames unknown = parts_.gates.unknown_frames(p);
    parts_.log.warning(
        Kind::dropping,
        fmt::format("a frame that names no known subject {} {} ({}): {}, {} bytes; {} so far",
                    sample.audit != 0 ? "would be dropped on" : "was dropped on", interface,
                    network, frame_name(sample), sample.len,
                    sample.audit != 0 ? unknown.would_drop : unknown.dropped),
        {.network = network});
    return;
  }
}

void GateEvents::repeat_missing(const core::Verdict& verdict) {
  const core::State& state = *parts_.scene.state;
  const auto done = parts_.gates.report_again(
      core::gate_state(state.system(), state.members(), verdict, parts_.scene.self));
  if (!done) parts_.log.error(Kind::trouble, done.error().text);
}

}  // namespace mlcca
