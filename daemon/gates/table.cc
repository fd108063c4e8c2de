// SPDX-License-Identifier: BSD-2-Clause
// The order of a change: the verdicts of the next generation are written in all tables, then the
// generation, then the verdicts that no program reads any more.
#include "daemon/gates/table.hpp"

#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gates/publish.hpp"

namespace mlcca::gates {

static_assert(GATE_FIRST_SLOT == 2, "slots 0 and 1 count what has no slot, in every table");

Result<void> VerdictTable::apply(const SlotChanges& changes) {
  const Change change{this, &changes};
  if (auto done = apply_together({&change, 1}); !done)
    return std::unexpected(std::move(done.error().error));
  return {};
}

std::expected<void, VerdictTable::Refusal> VerdictTable::apply_together(
    std::span<const Change> changes) {
  const auto refusal = [&](const Change& change, Error error) {
    return std::unexpected(
        Refusal{static_cast<std::size_t>(&change - changes.data()), std::move(error)});
  };
  for (const Change& c : changes)
    if (auto good = c.table->check(*c.changes); !good) return refusal(c, good.error());

  std::vector<Change> full;
  for (const Change& c : changes)
    if (!c.table->fits_at_once(*c.changes)) full.push_back(c);
  if (!full.empty()) {
    deny_what_goes(changes);
    for (const Change& c : full) c.table->remove_what_goes(*c.changes);
  }
  for (const Change& c : changes)
    if (auto room = c.table->reclaim(*c.changes); !room) {
      deny_what_goes(changes);
      return refusal(c, room.error());
    }

  for (const auto& [table, change] : changes) {
    table->put_what_comes(*change);
    table->stage_what_goes(*change);
    table->stage_what_comes(*change);
  }
  if (!changes.empty()) changes.front().table->next_generation();
  for (const auto& [table, change] : changes) {
    table->write_other_half();
    table->remove_what_goes(*change);
  }
  for (const Change& c : changes) c.table->watch_what_waits();
  return {};
}

void VerdictTable::deny_what_goes(std::span<const Change> changes) {
  for (const auto& [table, change] : changes) table->stage_what_goes(*change);
  changes.front().table->next_generation();
  for (const Change& c : changes) c.table->write_other_half();
}

void VerdictTable::stage_what_goes(const SlotChanges& changes) {
  stage(changes.close, GATE_DENY);
  stage(changes.remove, GATE_DENY);
}

void VerdictTable::stage_what_comes(const SlotChanges& changes) {
  for (const auto& s : changes.add)
    if (const auto slot = s.pass ? find(s) : std::nullopt) stage(*slot, GATE_PASS);
  stage(changes.open, GATE_PASS);
}

void VerdictTable::stage(const std::vector<SlotSpec>& specs, std::uint8_t verdict) {
  for (const auto& s : specs)
    if (const auto slot = find(s)) stage(*slot, verdict);
}

void VerdictTable::stage(std::uint32_t slot, std::uint8_t verdict) {
  if (verdict == GATE_PASS) forget_events(slot);
  publish(verdicts(slot)[(*generation_ + 1) & 1], verdict);
  staged_.push_back({slot, verdict});
  core::Progress::step();
}

void VerdictTable::next_generation() { publish(*generation_, *generation_ + 1); }

void VerdictTable::write_other_half() {
  for (const auto& [slot, verdict] : staged_) {
    publish(verdicts(slot)[(*generation_ + 1) & 1], verdict);
    note_watched(slot);
    core::Progress::step();
  }
  staged_.clear();
}

bool VerdictTable::passes(std::uint32_t slot) const {
  return verdicts(slot)[*generation_ & 1] == GATE_PASS;
}

void VerdictTable::undo_step(std::uint32_t slot) const {
  std::uint8_t* const halves = verdicts(slot);
  publish(halves[(*generation_ + 1) & 1], halves[*generation_ & 1]);
}

void VerdictTable::note_watched(std::uint32_t slot) {
  if (const std::uint16_t watch = supervised_watch(slot); watch != 0 && passes(slot))
    newly_watched_.insert(watch);
}

std::vector<std::uint16_t> VerdictTable::take_newly_watched() {
  const auto watches = std::exchange(newly_watched_, {});
  return {watches.begin(), watches.end()};
}

void VerdictTable::deny_all() {
  for (std::uint32_t slot = GATE_FIRST_SLOT; slot < slots_end(); ++slot) {
    if (passes(slot)) stage(slot, GATE_DENY);
    core::Progress::step();
  }
  next_generation();
  write_other_half();
}

}  // namespace mlcca::gates
