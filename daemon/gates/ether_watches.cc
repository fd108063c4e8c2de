// SPDX-License-Identifier: BSD-2-Clause
// Decides which slots of an Ethernet interface are watched: there are fewer watches than subjects.
#include <algorithm>

#include "core/model/progress.hpp"
#include "daemon/gates/ether_table.hpp"
#include "daemon/gates/publish.hpp"
#include "daemon/gates/watches.hpp"

namespace mlcca::enforce {

std::uint16_t EtherTable::watch_of(std::uint32_t slot) const { return memory_.slots[slot].watch; }

bool EtherTable::lacks_watch(const SlotSpec& spec) const {
  if (gate_gap_scale(spec.period) == 0) return false;
  const auto slot = find(spec);
  return !slot || watch_of(*slot) == 0;
}

/// A watch must name its slot before the slot names the watch.
void EtherTable::set_watch(std::uint32_t slot, const SlotSpec& spec) {
  if (gate_gap_scale(spec.period) == 0) {
    leave_watch(slot);
    return;
  }
  std::uint16_t watch = watch_of(slot);
  if (watch == 0) {
    if (watches_.free.empty()) {
      waiting_[slot] = {spec.period, spec.silence, spec.together};
      return;
    }
    watch = watches_.free.back();
    watches_.free.pop_back();
    memory_.watches[watch] = {};
    memory_.watches[watch].slot = slot;
    if (watch >= memory_.table->watches_end) publish(memory_.table->watches_end, __u32{watch} + 1);
    waiting_.erase(slot);
  }
  expect_events(memory_.watches[watch], spec);
  publish(memory_.slots[slot].watch, __u16{watch});
}

void EtherTable::leave_watch(std::uint32_t slot) {
  waiting_.erase(slot);
  const std::uint16_t watch = watch_of(slot);
  if (watch == 0) return;
  publish(memory_.slots[slot].watch, __u16{0});
  publish(memory_.watches[watch].silence, __u64{0});
  forget_watched(watch);
  watches_.quarantine.push_back(watch);
}

/// If waiting for the grace period fails, the next apply() tries again.
void EtherTable::watch_what_waits() {
  if (watches_.free.size() < waiting_.size() && !watches_.quarantine.empty())
    if (!release_what_was_left()) return;
  while (!waiting_.empty() && !watches_.free.empty()) {
    const auto [slot, expected] = *waiting_.begin();
    SlotSpec spec = spec_of(slot);
    spec.period = expected.period;
    spec.silence = expected.silence;
    spec.together = expected.together;
    set_watch(slot, spec);
    note_watched(slot);
    core::Progress::step();
  }
}

void EtherTable::forget_events(std::uint32_t slot) {
  if (const std::uint16_t watch = watch_of(slot); watch != 0)
    forget_findings(memory_.watches[watch]);
}

std::uint16_t EtherTable::supervised_watch(std::uint32_t slot) const {
  const std::uint16_t watch = watch_of(slot);
  return memory_.watches[watch].silence != 0 ? watch : std::uint16_t{0};
}

std::vector<std::uint16_t> EtherTable::watched() const {
  std::vector<std::uint16_t> watches;
  const std::uint32_t end = std::min<std::uint32_t>(memory_.table->watches_end, ETHER_WATCHES);
  for (std::uint32_t watch = 1; watch < end; ++watch)
    if (const auto slot = static_cast<std::uint32_t>(memory_.watches[watch].slot);
        slot < sizes_.slots && supervised_watch(slot) == watch && passes(slot))
      watches.push_back(static_cast<std::uint16_t>(watch));
  return watches;
}

}  // namespace mlcca::enforce
