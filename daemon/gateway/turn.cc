// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/turn.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

#include "core/gates/control_traffic.hpp"
#include "core/model/progress.hpp"

namespace mlcca {

void Turn::observe() {
  core::State& state = *parts_.scene.state;
  auto conditions = parts_.gates.conditions(state.system().networks.size());
  for (const ConditionSource* source : sources_) source->add_to(conditions);
  for (std::size_t n = 0; n < conditions.size(); ++n)
    state.set_condition(n, std::move(conditions[n]));
}

Result<void> Turn::settle(const core::FormerRules& left) {
  const core::Progress alive(parts_.pulse);
  core::State& state = *parts_.scene.state;
  const std::vector<core::DecisionChange> changes = state.settle();
  if (changes.empty()) return {};
  Result<void> done = parts_.gates.apply(state.gate_changes(changes, parts_.scene.self, left));
  if (!done) done = enforce();
  set_bands();
  for (const core::DecisionChange& change : changes) {
    parts_.recorder.note(change.channel);
    parts_.forwarding.want(change.channel);
    changed_(change);
    core::Progress::made();
  }
  parts_.deliveries.changes(changes);
  return done;
}

core::GateState Turn::wanted() const {
  auto all = parts_.scene.state->gate_state(parts_.scene.self);
  std::ranges::copy(
      core::control_rules(parts_.scene.state->system(), parts_.scene.self, ::geteuid()),
      std::back_inserter(all));
  return all;
}

Result<void> Turn::enforce() {
  const core::Progress alive(parts_.pulse);
  set_bands();
  parts_.pulse();
  auto all = wanted();
  parts_.pulse();
  auto done = parts_.gates.sync(all);
  in_line_ = done.has_value();
  parts_.pulse();
  parts_.recorder.note_slots(std::move(all));
  parts_.forwarding.want_all();
  if (!done)
    parts_.log.error(Kind::problem,
                     "denied as a whole, because the kernel refused: " + done.error().text);
  return done;
}

void Turn::commit() {
  if (!parts_.recorder.dirty()) return;
  // Entries that wait now were requested by other users before.
  const EventLog::Acting no_actor(parts_.log, std::nullopt);
  const Result<void> done = parts_.recorder.commit(lost_);
  committed_(done);
  if (done) return;
  // The decisions in force are part of what failed; note them again for the next commit.
  for (std::size_t c = 0; c < parts_.scene.state->decisions().size(); ++c)
    parts_.recorder.note_granted(c);
  parts_.recorder.note_ports();
  parts_.recorder.note_contradicted();
  parts_.recorder.note_slots(wanted());
}

void Turn::open_unless_lost() {
  if (parts_.gates.out_of_hand())
    parts_.control.close_all();
  else
    parts_.control.open();
}

void Turn::set_bands() {
  const core::State& state = *parts_.scene.state;
  for (std::size_t p = 0; p < parts_.gates.size(); ++p) {
    if (!parts_.gates.queues_by_priority(p)) continue;
    const std::size_t network = parts_.gates.network_number(p);
    const core::can::Schedule* bus = state.ledger().schedule(network);
    if (bus == nullptr) continue;
    core::Progress::made();
    const std::uint32_t queue = core::queue_of(state.system(), parts_.scene.self, network);
    const auto bands = core::can::bands_of(bus->assumptions(), bus->messages());
    std::array<std::uint32_t, GATE_BANDS - 1> limits{};
    limits.fill(~0U);
    for (std::size_t m = 0; m < bands.size(); ++m) {
      const core::can::Message& message = bus->messages()[m];
      if (message.queue != queue || bands[m] >= limits.size()) continue;
      std::uint32_t& limit = limits.at(bands[m]);
      const std::uint32_t last = std::max(message.priority, message.lowest_priority);
      limit = limit == ~0U ? last : std::max(limit, last);
    }
    parts_.gates.set_bands(p, limits);
  }
}

}  // namespace mlcca
