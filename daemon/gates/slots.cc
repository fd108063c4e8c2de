// SPDX-License-Identifier: BSD-2-Clause
// Edits chains of slots while a reader never waits: a slot is filled before it is linked, and is
// reused only when no reader can hold it any more.
#include "daemon/gates/slots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gates/bindings.hpp"
#include "daemon/gates/publish.hpp"
#include "daemon/gates/watches.hpp"

namespace mlcca::gates {
namespace {

constexpr std::uint32_t kLargestIfindex = 0x7fffffff;
constexpr std::uint32_t kLargestOrigin = 0x7fffffff;

bool has_origin(Direction direction, std::uint32_t source) {
  return gate_has_origin(std::to_underlying(direction), source) != 0;
}

std::uint8_t formats_of(const SlotSpec& s) {
  return static_cast<std::uint8_t>(s.formats | (s.excess_passes ? GATE_EXCESS_PASSES : 0));
}

std::string name(const SlotSpec& s) {
  return fmt::format("slot of subject {:#018x} (identifier {:#x}, {})", s.subject, s.id,
                     to_text(s.direction));
}

/// The bits that a mask must have so that the key leads to the slot.
std::uint32_t whole_key(const SlotSpec& s, std::uint32_t profile) {
  const std::uint32_t key = gate_key_mask(profile, s.id);
  return (s.id & CAN_EFF_FLAG) != 0 ? key : key & (CAN_EFF_FLAG | CAN_SFF_MASK);
}

bool masks_key(const SlotSpec& s, std::uint32_t profile) {
  const std::uint32_t needed = whole_key(s, profile);
  return (s.mask & needed) != needed;
}

Result<void> check_spec(const SlotSpec& s, std::uint32_t profile) {
  if (gate_bucket(profile, s.id) == GATE_NO_BUCKET)
    return fail(name(s) + ": the interface's profile has no such identifier");
  if ((s.id & ~s.mask) != 0) return fail(name(s) + ": the identifier has bits outside its mask");
  if ((s.id & CAN_EFF_FLAG) == 0 && (s.id & CAN_EFF_MASK) > CAN_SFF_MASK)
    return fail(name(s) + ": an 11-bit identifier is at most 0x7ff");
  if ((s.mask & CAN_EFF_FLAG) == 0)
    return fail(name(s) + ": the mask leaves open whether there are 11 or 29 bits");
  if (masks_key(s, profile) && gate_has_masks(profile) == 0)
    return fail(name(s) + ": the mask leaves part of the key open");
  if ((s.id & CAN_ERR_FLAG) != 0) return fail(name(s) + ": error frames have no slot");
  if ((s.formats & ~GATE_TRANSPORT) == 0 ||
      (s.formats & ~(GATE_CLASSIC | GATE_FD | GATE_XL | GATE_TRANSPORT)) != 0)
    return fail(name(s) + ": neither classic nor FD nor XL");
  if ((s.formats & GATE_TRANSPORT) != 0 &&
      (gate_has_transport(profile) == 0 || s.formats != (GATE_CLASSIC | GATE_TRANSPORT)))
    return fail(name(s) + ": the transport protocol is of J1939, in classic frames");
  if ((s.formats & GATE_XL) != 0 && (s.id & CAN_EFF_FLAG) != 0)
    return fail(name(s) + ": CAN XL has 11 bits of priority");
  if (s.source > kLargestIfindex && s.source != GATE_NO_SOURCE)
    return fail(name(s) + ": the source is no interface");
  if (s.origin > kLargestOrigin) return fail(name(s) + ": that is no origin");
  if (has_origin(s.direction, s.source) ? s.uid != GATE_ANY_UID : s.origin != 0)
    return fail(name(s) + ": programs have users, and what came in by an interface an origin");
  return {};
}

}  // namespace

SlotTable::SlotTable(const Memory& memory, std::uint32_t profile, GracePeriod wait)
    : VerdictTable(memory.generation),
      table_(&memory.table),
      cpus_(memory.cpus),
      profile_(profile),
      wait_(std::move(wait)) {}

Result<SlotTable> SlotTable::read(const Memory& memory, std::uint32_t profile, bool fresh,
                                  GracePeriod wait) {
  return read(memory, profile, fresh, false, std::move(wait));
}

Result<SlotTable> SlotTable::read_as_found(const Memory& memory, std::uint32_t profile) {
  return read(memory, profile, false, true, nullptr);
}

Result<SlotTable> SlotTable::read(const Memory& memory, std::uint32_t profile, bool fresh,
                                  bool as_found, GracePeriod wait) {
  gate_table& table = memory.table;
  if (fresh) {
    table.layout_version = GATE_LAYOUT_VERSION;
    table.profile = profile;
  }
  if (table.layout_version != GATE_LAYOUT_VERSION)
    return fail(fmt::format("slot table: layout {} instead of {}", table.layout_version,
                            GATE_LAYOUT_VERSION));
  if (table.profile != profile)
    return fail(
        fmt::format("slot table: filled for profile {} instead of {}", table.profile, profile));
  SlotTable slots(memory, profile, std::move(wait));
  if (auto adopted = slots.adopt(fresh, as_found); !adopted)
    return std::unexpected(adopted.error());
  return slots;
}

/// Finds the used slots by following the chains, which alone say what is used. All others are free.
Result<void> SlotTable::adopt(bool fresh, bool as_found) {
  std::vector<bool> seen(GATE_SLOTS, false);
  Result<void> sound;
  for_each_chain([&](Direction direction, std::uint32_t bucket, std::uint16_t first) {
    for (std::uint16_t at = first; at != 0 && sound; at = table_->slots[at].next) {
      if (at < GATE_FIRST_SLOT || at >= GATE_SLOTS || seen[at]) {
        sound = fail(fmt::format("slot table: broken chain in bucket {}", bucket));
        return;
      }
      const SlotSpec spec = spec_of(at, direction);
      if (!as_found &&
          (is_masked(spec) ? GATE_NO_BUCKET : gate_bucket(profile_, spec.id)) != bucket)
        sound = fail(fmt::format("slot table: slot {} is in the wrong bucket", at));
      seen[at] = true;
      ++used_;
      undo_step(at);
      core::Progress::step();
    }
  });
  if (!sound) return sound;
  auto& unused = fresh ? free_ : quarantine_;
  unused.reserve(GATE_SLOTS - GATE_FIRST_SLOT - used_);
  std::uint16_t slot = GATE_SLOTS;
  while (slot-- > GATE_FIRST_SLOT)
    if (!seen[slot]) unused.push_back(slot);
  return {};
}

template <class Use>
void SlotTable::for_each_chain(const Use& use) const {
  for (const auto direction : {Direction::ingress, Direction::egress}) {
    const auto d = std::to_underlying(direction);
    for (std::uint32_t bucket = 0; bucket < GATE_BUCKETS; ++bucket)
      if (const std::uint16_t first = table_->head[d][bucket]; first != 0)
        use(direction, bucket, first);
    if (const std::uint16_t first = table_->masked[d]; first != 0)
      use(direction, GATE_NO_BUCKET, first);
  }
}

bool SlotTable::is_masked(const SlotSpec& spec) const { return masks_key(spec, profile_); }

std::uint16_t* SlotTable::head(const SlotSpec& spec) const {
  if (is_masked(spec)) return &table_->masked[std::to_underlying(spec.direction)];
  return &table_->head[std::to_underlying(spec.direction)][gate_bucket(profile_, spec.id)];
}

std::vector<std::uint16_t> SlotTable::chain(const SlotSpec& spec) const {
  std::vector<std::uint16_t> slots;
  for (std::uint16_t at = *head(spec); at != 0; at = table_->slots[at].next) slots.push_back(at);
  return slots;
}

SlotSpec SlotTable::spec_of(std::uint16_t slot, Direction direction) const {
  const gate_slot& s = table_->slots[slot];
  const bool origin = has_origin(direction, s.source);
  return {.direction = direction,
          .pass = passes(slot),
          .max_len = s.max_len,
          .formats = static_cast<std::uint8_t>(s.formats & ~GATE_EXCESS_PASSES),
          .id = s.id,
          .mask = s.mask,
          .source = s.source,
          .uid = origin ? GATE_ANY_UID : s.uid,
          .origin = origin ? s.origin : 0,
          .subject = s.subject,
          .per_frame = s.per_frame,
          .per_byte = s.per_byte,
          .tolerance = s.tolerance,
          .excess_passes = (s.formats & GATE_EXCESS_PASSES) != 0,
          .period = table_->watches[slot].period,
          .silence = table_->watches[slot].silence,
          .together = table_->watches[slot].together};
}

std::optional<std::uint32_t> SlotTable::find(const SlotSpec& spec) const {
  if (gate_bucket(profile_, spec.id) == GATE_NO_BUCKET) return std::nullopt;
  for (const auto slot : chain(spec))
    if (spec_of(slot, spec.direction).same_grant(spec)) return slot;
  return std::nullopt;
}

std::vector<SlotSpec> SlotTable::present() const {
  std::vector<SlotSpec> specs;
  specs.reserve(used_);
  for_each_chain([&](Direction direction, std::uint32_t, std::uint16_t first) {
    for (std::uint16_t at = first; at != 0; at = table_->slots[at].next) {
      specs.push_back(spec_of(at, direction));
      core::Progress::step();
    }
  });
  return specs;
}

Result<void> SlotTable::check(const SlotChanges& changes) const {
  std::set<SlotSpec, ByGrant> added;
  for (const auto& s : changes.add) {
    core::Progress::step();
    if (auto good = check_spec(s, profile_); !good) return good;
    if (find(s) || !added.insert(s).second) return fail(name(s) + " is there already");
  }
  std::set<SlotSpec, ByGrant> removed;
  for (const auto& s : changes.remove) {
    core::Progress::step();
    if (!find(s) || !removed.insert(s).second) return fail(name(s) + " to be removed is not there");
  }
  for (const auto* list : {&changes.close, &changes.open, &changes.police})
    for (const auto& s : *list) {
      if (!find(s)) return fail(name(s) + " is not there");
      core::Progress::step();
    }
  for (const auto& s : changes.open)
    if (removed.contains(s)) return fail(name(s) + " is to be opened and removed");
  return check_room(changes);
}

/// Checks the state after the changes.
Result<void> SlotTable::check_room(const SlotChanges& changes) const {
  if (used_ + changes.add.size() - changes.remove.size() > GATE_SLOTS - GATE_FIRST_SLOT)
    return fail(fmt::format("more than {} slots on one interface", GATE_SLOTS - GATE_FIRST_SLOT));
  using Key = std::pair<Direction, std::uint32_t>;
  std::map<Key, std::ptrdiff_t> keys;
  std::map<const std::uint16_t*, std::ptrdiff_t> chains;
  const auto key_of = [&](const SlotSpec& s) {
    return Key{s.direction, s.id & gate_key_mask(profile_, s.id)};
  };
  const auto count = [&](const SlotSpec& s, std::ptrdiff_t n) {
    if (!is_masked(s)) keys[key_of(s)] += n;
    chains[head(s)] += n;
    core::Progress::step();
  };
  for (const auto& s : changes.add) {
    if (!chains.contains(head(s)))
      for (const auto slot : chain(s)) count(spec_of(slot, s.direction), 1);
    count(s, 1);
  }
  for (const auto& s : changes.remove)
    if (chains.contains(head(s))) count(s, -1);
  for (const auto& s : changes.add) {
    if (!is_masked(s) && keys[key_of(s)] > GATE_CHAIN)
      return fail(
          fmt::format("{}: more than {} publishers with this identifier", name(s), GATE_CHAIN));
    if (chains[head(s)] <= GATE_WALK) continue;
    return fail(fmt::format(
        fmt::runtime(is_masked(s) ? "{}: more than {} slots with a mask in one direction"
                                  : "{}: more than {} slots whose identifiers fall together"),
        name(s), GATE_WALK));
  }
  return {};
}

bool SlotTable::fits_at_once(const SlotChanges& changes) const {
  if (changes.add.size() > free_.size() + quarantine_.size()) return false;
  std::map<const std::uint16_t*, std::size_t> lengths;
  for (const auto& s : changes.add) {
    auto [entry, first] = lengths.try_emplace(head(s), 0);
    if (first) entry->second = chain(s).size();
    if (++entry->second > GATE_WALK) return false;
    core::Progress::step();
  }
  return true;
}

Result<void> SlotTable::reclaim(const SlotChanges& changes) {
  if (free_.size() >= changes.add.size()) return {};
  if (auto waited = wait_(); !waited) return waited;
  free_.insert(free_.begin(), quarantine_.begin(), quarantine_.end());
  quarantine_.clear();
  return {};
}

void SlotTable::put_what_comes(const SlotChanges& changes) {
  for (const auto& s : changes.add) link(s);
  for (const auto& s : changes.police) set_traffic(s);
}

void SlotTable::remove_what_goes(const SlotChanges& changes) {
  for (const auto& s : changes.remove)
    if (find(s)) unlink(s);
}

void SlotTable::link(const SlotSpec& spec) {
  const std::uint16_t slot = free_.back();
  free_.pop_back();
  for (auto& cpu : cpus_) cpu.slots[slot] = {};
  table_->last_reason[slot] = GATE_R_PASSED;
  table_->audit[slot] = {};
  table_->slots[slot] = {.verdict = {GATE_DENY, GATE_DENY},
                         .max_len = spec.max_len,
                         .id = spec.id,
                         .mask = spec.mask,
                         .source = spec.source,
                         .origin = has_origin(spec.direction, spec.source) ? spec.origin : spec.uid,
                         .next = *head(spec),
                         .formats = formats_of(spec),
                         .contradicted = 0,
                         .subject = spec.subject,
                         .per_frame = spec.per_frame,
                         .per_byte = spec.per_byte,
                         .tolerance = spec.tolerance,
                         .due = 0};
  table_->watches[slot] = {};
  expect_events(table_->watches[slot], spec);
  if (slot >= table_->slots_end) publish(table_->slots_end, slot + 1U);
  publish(*head(spec), slot);
  core::Progress::step();
  if (gate_has_broker(profile_) != 0 && Bindings(*table_).is_contradicted(table_->slots[slot]))
    publish(table_->slots[slot].contradicted, __u8{1});
  ++used_;
}

/// The slot keeps its `next`, so that a program that reads it finds the rest of the chain.
void SlotTable::unlink(const SlotSpec& spec) {
  const auto slot = static_cast<std::uint16_t>(find(spec).value_or(0));
  std::uint16_t* before = head(spec);
  while (*before != slot) before = &table_->slots[*before].next;
  publish(*before, table_->slots[slot].next);
  quarantine_.push_back(slot);
  --used_;
  core::Progress::step();
}

/// Changes one word after the other: a frame in between meets at most the old rate with the new
/// tolerance.
void SlotTable::set_traffic(const SlotSpec& spec) {
  const auto found = find(spec);
  if (!found) return;
  gate_slot& slot = table_->slots[*found];
  const bool other_rate = slot.per_frame != spec.per_frame || slot.per_byte != spec.per_byte ||
                          slot.tolerance != spec.tolerance;
  publish(slot.per_frame, __u64{spec.per_frame});
  publish(slot.per_byte, __u64{spec.per_byte});
  publish(slot.tolerance, __u64{spec.tolerance});
  publish(slot.formats, formats_of(spec));
  // Turns that were reserved at the former rate have no meaning at the new one.
  if (other_rate) publish(slot.due, __u64{0});
  expect_events(table_->watches[*found], spec);
  note_watched(*found);
  core::Progress::step();
}

void SlotTable::forget_events(std::uint32_t slot) { forget_findings(table_->watches[slot]); }

std::uint16_t SlotTable::watch_of(std::uint32_t slot) const {
  return table_->watches[slot].period != 0 ? static_cast<std::uint16_t>(slot) : std::uint16_t{0};
}

std::uint16_t SlotTable::supervised_watch(std::uint32_t slot) const {
  return table_->watches[slot].silence != 0 ? static_cast<std::uint16_t>(slot) : std::uint16_t{0};
}

std::vector<std::uint16_t> SlotTable::watched() const {
  std::vector<std::uint16_t> slots;
  for_each_chain([&](Direction, std::uint32_t, std::uint16_t first) {
    for (std::uint16_t at = first; at != 0; at = table_->slots[at].next)
      if (passes(at) && supervised_watch(at) != 0) slots.push_back(at);
  });
  return slots;
}

}  // namespace mlcca::gates
