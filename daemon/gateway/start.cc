// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/start.hpp"

#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gateway/in_time.hpp"

namespace mlcca {
namespace {

/// The time for which a start waits for the sources of links, in ns. It is well below the grace in
/// which the gates stay as they were.
constexpr std::uint64_t kFirstReports = 2'500'000'000;

}  // namespace

std::optional<StartError> Start::run() {
  const core::Progress goes_on(parts_.pulse);
  auto failure = begin_start();
  if (!failure) failure = read_what_was();
  if (!failure) failure = open_gates();
  if (failure) parts_.outside.control.close_all();
  return failure;
}

/// First step of a start. Whatever a previous daemon has left in the gates stays in force.
std::optional<StartError> Start::begin_start() {
  parts_.started = parts_.outside.clock.unix_ns() / 1'000'000'000;
  if (const auto set = parts_.outside.control.set_grace(parts_.options.grace_ns); !set)
    return StartError{{set.error().text}};
  if (const auto begun = parts_.heartbeat.begin_start(parts_.options.start_limit_ns); !begun)
    parts_.outside.log.warning(Kind::problem,
                               "nothing is kept after the grace: " + begun.error().text);
  parts_.heartbeat.pulse();
  return std::nullopt;
}

/// Second step of a start: reads the journal, the history and the description.
std::optional<StartError> Start::read_what_was() {
  if (const auto opened = parts_.recorder.open(parts_.options.state_directory, parts_.outside.disk);
      !opened)
    return StartError{{opened.error().text}};
  parts_.history.emplace(parts_.patience.wait_for(
      [this] { return store::History::open(parts_.options.state_directory); }));
  parts_.outside.log.keep_in(*parts_.history);
  if (parts_.rollout) parts_.rollout->restore(parts_.recorder.contents().membership);
  const ReadDescription from = parts_.reader();
  auto read = parts_.outside.threads ? in_time(from, parts_.options.read_limit_ns, parts_.pulse)
                                     : std::optional(from());
  reads_for_ever_ = !read;
  if (!read) return StartError{{not_read_in_time(parts_.options)}};
  parts_.heartbeat.pulse();
  DescribedResult& described = *read;
  if (!described) return described.error();
  for (const std::string& note : described->notes) parts_.outside.log.warning(Kind::problem, note);
  auto left_out = parts_.reloads.complete(*described);
  parts_.heartbeat.pulse();
  if (!left_out) return left_out.error();
  parts_.scene.state = std::move(described->state);
  parts_.scene.self = described->self;
  parts_.scene.digest = described->digest;
  parts_.scene.file_digest = described->file_digest;
  parts_.scene.unchecked = described->unchecked;
  parts_.scene.text = std::move(described->text);
  parts_.admissions.set_left_out(std::move(*left_out));
  parts_.reloads.note_loaded();
  if (const auto& cut = parts_.recorder.recovered()) parts_.outside.log.notice(Kind::problem, *cut);
  parts_.admissions.remember();
  parts_.context.emplace(Context{
      parts_.options,  parts_.outside.clock,    parts_.outside.gates, parts_.outside.control,
      parts_.scene,    parts_.outside.log,      parts_.deliveries,    parts_.turn,
      parts_.recorder, parts_.admissions,       parts_.tags,          parts_.gate_events,
      parts_.audit,    parts_.audit_keeper,     parts_.modes,         parts_.delivery_health,
      parts_.health,   parts_.channels,         parts_.endpoints,     parts_.carriers,
      parts_.presence, parts_.local_ends,       parts_.forwarding,    parts_.meshes,
      parts_.reloads,  parts_.estimates,        parts_.replies,       parts_.patience,
      *parts_.history, parts_.membership.get(), parts_.started});
  return std::nullopt;
}

/// Last step of a start: writes the decided slots to the gates, and lets the gates use their
/// verdicts.
std::optional<StartError> Start::open_gates() {
  const auto before = parts_.recorder.granted();
  GateControl& control = parts_.outside.control;
  parts_.modes.begin(parts_.options.initial_audit);
  if (const auto done = control.undo_interrupted_step(); !done)
    return StartError{{done.error().text}};
  parts_.meshes.describe(parts_.scene.state->system(), parts_.scene.self);
  parts_.meshes.await_first_reports(kFirstReports, parts_.pulse);
  parts_.presence.start();
  if (parts_.membership) {
    parts_.membership->begin();
    parts_.membership->await(kFirstReports);
  }
  if (const auto done =
          parts_.reconciler.put_in_force(before, TagBindings::Known::by_gates_and_disk);
      !done)
    parts_.outside.log.error(Kind::problem, done.error().text);
  if (parts_.membership) parts_.membership->in_force();
  if (const auto uncapped = forget_former_limit(); !uncapped)
    return StartError{{uncapped.error().text}};
  if (const auto done = control.listen(
          {[this](const gate_event& event) { parts_.gate_events.on_event(event); },
           [this](const gate_sample& sample) { parts_.gate_events.on_sample(sample); }});
      !done)
    return StartError{{done.error().text}};
  if (const auto alive = control.beat(parts_.outside.clock.monotonic_ns()); !alive)
    return StartError{{alive.error().text}};
  if (const auto armed = control.arm(); !armed) return StartError{{armed.error().text}};
  if (control.lapsed())
    if (const auto cleared = control.clear_lapse(parts_.outside.clock.monotonic_ns()); !cleared)
      return StartError{{cleared.error().text}};
  parts_.heartbeat.end_start();
  parts_.presence.start();  // during the start nobody could announce itself
  parts_.delivery_health.forget(parts_.pulse);
  parts_.drops.forget();  // what a previous daemon has counted is not reported again
  parts_.turn.open_unless_lost();
  parts_.outside.log.notice(Kind::started, "started: " + parts_.summary());
  parts_.modes.report();
  if (parts_.history) parts_.audit_keeper.restore(*parts_.history);
  parts_.admissions.report_left_out();
  parts_.deliveries.outcome(before, {});
  parts_.forwarding.act();
  parts_.turn.commit();
  return std::nullopt;
}

/// An earlier daemon, which took part in a cluster, may have left a limit of time in the kernel.
/// This daemon shares nothing, so it removes the limit.
Result<void> Start::forget_former_limit() {
  if (parts_.membership || parts_.outside.control.until() == 0) return {};
  return parts_.outside.control.set_until(0);
}

}  // namespace mlcca
