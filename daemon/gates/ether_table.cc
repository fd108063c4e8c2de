// SPDX-License-Identifier: BSD-2-Clause
// Edits chains while a reader never waits, as slots.cc does. A bucket is one word, so its first
// slot and the fingerprints of its subjects change together.
#include "daemon/gates/ether_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gates/publish.hpp"
#include "daemon/gates/watches.hpp"

namespace mlcca::gates {
namespace {

constexpr unsigned kHalf = 32;  // half of the bits of a station

constexpr std::uint32_t kLargestIfindex = 0x7fffffff;

std::string name(const SlotSpec& s) {
  return fmt::format("slot of subject {:#018x} ({})", s.subject, to_text(s.direction));
}

/// Whether this is a value of ether_station().
bool is_station(std::uint64_t station) {
  constexpr std::uint64_t pan_and_address = 0xffffffff;
  return (station & ETHER_EXTENDED) != 0 || station < ETHER_SHORT ||
         (station & ~pan_and_address) == ETHER_SHORT;
}

Result<void> check_spec(const SlotSpec& s) {
  if (s.id != 0 || s.mask != 0) return fail(name(s) + ": an Ethernet frame has no identifier");
  if (s.formats == 0 || (s.formats & ~(ETHER_UNFRAGMENTED | ETHER_FRAGMENT)) != 0)
    return fail(name(s) + ": neither unfragmented events nor fragments");
  if (s.max_len > ETHER_MAX_PAYLOAD)
    return fail(
        fmt::format("{}: a datagram has at most {} bytes of payload", name(s), ETHER_MAX_PAYLOAD));
  if (!is_station(s.station)) return fail(name(s) + ": that is no address of a station");
  if (s.source > kLargestIfindex) return fail(name(s) + ": the source is no interface");
  return {};
}

using Key = std::pair<Direction, std::uint64_t>;
Key key(const SlotSpec& s) { return {s.direction, s.subject}; }
auto grant(const SlotSpec& s) {
  return std::tie(s.direction, s.subject, s.station, s.source, s.uid, s.max_len, s.formats);
}

/// Pointers in an order that groups the slots of one subject, without copying the slots.
std::vector<const SlotSpec*> sorted(const std::vector<SlotSpec>& specs) {
  std::vector<const SlotSpec*> out;
  out.reserve(specs.size());
  for (const SlotSpec& s : specs) out.push_back(&s);
  std::ranges::sort(out, [](const SlotSpec* a, const SlotSpec* b) {
    core::Progress::step();
    return grant(*a) < grant(*b);
  });
  return out;
}

Result<void> check_once(const std::vector<SlotSpec>& specs) {
  const auto all = sorted(specs);
  const auto twice = std::ranges::adjacent_find(
      all, [](const SlotSpec* a, const SlotSpec* b) { return grant(*a) == grant(*b); });
  if (twice == all.end()) return {};
  return fail(name(**twice) + " is there twice");
}

}  // namespace

EtherSizes EtherSizes::for_slots(std::size_t slots, std::uint32_t cpus) {
  EtherSizes out;
  out.slots = static_cast<std::uint32_t>(
      std::clamp<std::size_t>(slots + ETHER_FIRST_SLOT, ETHER_MIN_SLOTS, ETHER_MAX_SLOTS));
  out.buckets = std::bit_ceil(out.slots);
  out.contracts = std::min<std::uint32_t>(out.slots, ETHER_CONTRACTS);
  out.banks = out.slots <= ETHER_BANKED_SLOTS ? cpus : 1;
  return out;
}

EtherTable::EtherTable(const EtherMemory& memory, const EtherSizes& sizes, GracePeriod wait)
    : VerdictTable(*memory.generation), memory_(memory), sizes_(sizes), wait_(std::move(wait)) {}

Result<EtherTable> EtherTable::read(const EtherMemory& memory, const EtherSizes& sizes, bool fresh,
                                    std::uint64_t seed, GracePeriod wait) {
  ether_table& head = *memory.table;
  if (fresh)
    head = {.layout_version = ETHER_LAYOUT_VERSION,
            .slots = sizes.slots,
            .buckets = sizes.buckets,
            .banks = sizes.banks,
            .seed = seed,
            .unknown_frames = 0,
            .contracts = sizes.contracts,
            .watches_end = 1,
            .sample_due = 0,
            .retired = 0,
            .epoch = 0,
            .refused_senders = 0,
            .would_drop = {}};
  if (head.layout_version != ETHER_LAYOUT_VERSION)
    return fail(fmt::format("subject table: layout {} instead of {}", head.layout_version,
                            ETHER_LAYOUT_VERSION));
  if (EtherSizes{head.slots, head.buckets, head.contracts, head.banks} != sizes)
    return fail("subject table: of another size");
  EtherTable table(memory, sizes, std::move(wait));
  if (auto adopted = table.adopt(fresh); !adopted) return std::unexpected(adopted.error());
  return table;
}

std::uint64_t EtherTable::hash_of(std::uint64_t subject, Direction direction) const {
  return ether_hash(memory_.table->seed, subject, std::to_underlying(direction));
}

std::uint64_t EtherTable::hash_at(std::uint32_t slot) const {
  return hash_of(memory_.slots[slot].subject,
                 static_cast<Direction>(memory_.slots[slot].direction));
}

std::uint8_t* EtherTable::prefilter_at(std::uint64_t hash) const {
  if (!sizes_.has_prefilter()) return nullptr;
  const std::uint64_t bucket = hash & (sizes_.buckets - 1);
  return &memory_.prefilters[bucket / ETHER_PREFILTER_BUCKETS]
              .bits[bucket % ETHER_PREFILTER_BUCKETS];
}

std::uint64_t& EtherTable::bucket_of(std::uint64_t hash) const {
  return memory_.buckets[hash & (sizes_.buckets - 1)];
}

/// Finds the used slots by following the chains, which alone say what is used. All others are free.
Result<void> EtherTable::adopt(bool fresh) {
  std::vector<bool> seen(sizes_.slots, false);
  for (std::size_t b = 0; b < memory_.buckets.size(); ++b) {
    if (auto good = adopt_chain(b, seen); !good) return good;
    core::Progress::step();
  }
  auto& unused = fresh ? slots_.free : slots_.quarantine;
  unused.reserve(sizes_.slots - ETHER_FIRST_SLOT - used_);
  for (std::uint32_t slot = sizes_.slots; slot-- > ETHER_FIRST_SLOT;)
    if (!seen[slot]) unused.push_back(slot);
  std::vector<bool> used(sizes_.contracts, false);
  for (const auto& [contract, use] : contracts_) used[use.number] = true;
  auto& numbers = fresh ? contract_numbers_.free : contract_numbers_.quarantine;
  for (std::uint32_t n = sizes_.contracts; n-- > 1;)
    if (!used[n]) numbers.push_back(static_cast<std::uint16_t>(n));
  std::vector<bool> watching(ETHER_WATCHES, false);
  for (std::uint32_t slot = ETHER_FIRST_SLOT; slot < sizes_.slots; ++slot)
    if (seen[slot]) watching[memory_.slots[slot].watch] = true;
  auto& watches = fresh ? watches_.free : watches_.quarantine;
  for (std::uint16_t n = ETHER_WATCHES; n-- > 1;)
    if (!watching[n]) watches.push_back(n);
  return {};
}

Result<void> EtherTable::adopt_chain(std::size_t bucket, std::vector<bool>& seen) {
  auto at = static_cast<std::uint32_t>(memory_.buckets[bucket]);
  bool wildcard_before = false;
  for (; at != 0; at = memory_.slots[at].next) {
    if (at < ETHER_FIRST_SLOT || at >= sizes_.slots || seen[at])
      return fail(fmt::format("subject table: broken chain in bucket {}", bucket));
    if (auto good = check_adopted(at, bucket); !good) return good;
    const bool is_wildcard = station_of(at) == 0;
    if (!is_wildcard && wildcard_before)
      return fail(fmt::format("subject table: slot {} of a station stands behind others", at));
    wildcard_before = is_wildcard;
    if (auto good = adopt_contract(at); !good) return good;
    seen[at] = true;
    ++used_;
    undo_step(at);
    core::Progress::step();
  }
  return {};
}

Result<void> EtherTable::check_adopted(std::uint32_t at, std::size_t bucket) const {
  const ether_slot& slot = memory_.slots[at];
  const std::uint64_t hash = hash_at(at);
  const std::uint8_t* prefilter = prefilter_at(hash);
  if (slot.direction >= GATE_DIRECTIONS || (hash & (sizes_.buckets - 1)) != bucket ||
      (memory_.buckets[bucket] & ether_fingerprint(hash)) == 0 ||
      (prefilter != nullptr &&
       (*prefilter & ether_prefilter_bits(hash)) != ether_prefilter_bits(hash)))
    return fail(fmt::format("subject table: slot {} is in the wrong bucket", at));
  if (slot.contract == 0 || slot.contract >= sizes_.contracts)
    return fail(fmt::format("subject table: slot {} has no contract", at));
  if (slot.watch >= ETHER_WATCHES || (slot.watch != 0 && memory_.watches[slot.watch].slot != at))
    return fail(fmt::format("subject table: the watch of slot {} is of another", at));
  return {};
}

/// Two numbers for one contract would count as one. This program never writes that.
Result<void> EtherTable::adopt_contract(std::uint32_t at) {
  const std::uint16_t number = memory_.slots[at].contract;
  Use& use = contracts_[contract_of(spec_of(at))];
  if (use.slots != 0 && use.number != number)
    return fail(fmt::format("subject table: contract {} is there twice", number));
  use.number = number;
  ++use.slots;
  return {};
}

EtherTable::Contract EtherTable::contract_of(const SlotSpec& s) {
  return {s.uid,
          s.source,
          static_cast<std::uint32_t>(s.station >> kHalf),
          s.max_len,
          static_cast<std::uint16_t>(s.formats | (s.excess_passes ? GATE_EXCESS_PASSES : 0)),
          s.per_frame,
          s.per_byte,
          s.tolerance};
}

std::uint64_t EtherTable::station_of(std::uint32_t at) const {
  const ether_slot& slot = memory_.slots[at];
  return ether_station(&slot, &memory_.contracts[slot.contract]);
}

SlotSpec EtherTable::spec_of(std::uint32_t at) const {
  const ether_slot& slot = memory_.slots[at];
  const ether_contract& c = memory_.contracts[slot.contract];
  SlotSpec s;
  s.direction = static_cast<Direction>(slot.direction);
  s.pass = passes(at);
  s.max_len = c.max_len;
  s.formats = static_cast<std::uint8_t>(c.forms & ~GATE_EXCESS_PASSES);
  s.source = c.source;
  s.uid = c.uid;
  s.station = station_of(at);
  s.subject = slot.subject;
  s.per_frame = c.per_frame;
  s.per_byte = c.per_byte;
  s.tolerance = c.tolerance;
  s.excess_passes = (c.forms & GATE_EXCESS_PASSES) != 0;
  if (slot.watch != 0) {
    const gate_watch& watch = memory_.watches[slot.watch];
    s.period = watch.period;
    s.silence = watch.silence;
    s.together = watch.together;
  }
  return s;
}

std::optional<std::uint32_t> EtherTable::find(const SlotSpec& spec) const {
  auto at = static_cast<std::uint32_t>(bucket_of(hash_of(spec.subject, spec.direction)));
  for (; at != 0; at = memory_.slots[at].next)
    if (memory_.slots[at].subject == spec.subject && spec_of(at).same_grant(spec)) return at;
  return std::nullopt;
}

std::vector<SlotSpec> EtherTable::present() const {
  std::vector<SlotSpec> specs;
  specs.reserve(used_);
  for (const std::uint64_t bucket : memory_.buckets) {
    core::Progress::step();
    for (auto at = static_cast<std::uint32_t>(bucket); at != 0; at = memory_.slots[at].next)
      specs.push_back(spec_of(at));
  }
  return specs;
}

// --- changes ------------------------------------------------------------------------------------

std::set<EtherTable::Contract> EtherTable::new_contracts(const SlotChanges& changes) const {
  std::set<Contract> fresh;
  for (const auto* list : {&changes.add, &changes.police})
    for (const auto& s : *list) {
      if (!contracts_.contains(contract_of(s))) fresh.insert(contract_of(s));
      core::Progress::step();
    }
  return fresh;
}

/// If nothing is removed, check() has checked the same.
bool EtherTable::fits_at_once(const SlotChanges& changes) const {
  return changes.remove.empty() || (changes.add.size() <= slots_.size() &&
                                    new_contracts(changes).size() <= contract_numbers_.size() &&
                                    check_chains(changes, false).has_value());
}

/// Waits for recently removed entries if they are needed; check() has found that they suffice.
/// There may still be too few watches.
Result<void> EtherTable::reclaim(const SlotChanges& changes) {
  const auto watches = [&] {
    std::size_t count = 0;
    for (const auto* list : {&changes.add, &changes.police})
      count += static_cast<std::size_t>(std::ranges::count_if(*list, [&](const SlotSpec& s) {
        core::Progress::step();
        return lacks_watch(s);
      }));
    return count;
  };
  const bool enough = slots_.free.size() >= changes.add.size() &&
                      (contract_numbers_.quarantine.empty() ||
                       contract_numbers_.free.size() >= new_contracts(changes).size()) &&
                      (watches_.quarantine.empty() || watches_.free.size() >= watches());
  return enough ? Result<void>{} : release_what_was_left();
}

Result<void> EtherTable::release_what_was_left() {
  if (auto waited = wait_(); !waited) return waited;
  slots_.release();
  contract_numbers_.release();
  watches_.release();
  return {};
}

void EtherTable::put_what_comes(const SlotChanges& changes) {
  for (const auto& s : changes.add) link(s);
  for (const auto& s : changes.police) set_traffic(s);
}

void EtherTable::remove_what_goes(const SlotChanges& changes) {
  for (const auto& s : changes.remove)
    if (find(s)) unlink(s);
}

std::uint16_t EtherTable::take_contract(const SlotSpec& spec) {
  auto [at, fresh] = contracts_.try_emplace(contract_of(spec));
  Use& use = at->second;
  ++use.slots;
  if (!fresh) return use.number;
  use.number = contract_numbers_.free.back();
  contract_numbers_.free.pop_back();
  const Contract& c = at->first;
  memory_.contracts[use.number] = {.uid = c.uid,
                                   .source = c.source,
                                   .station_high = c.station_high,
                                   .max_len = c.max_len,
                                   .forms = c.forms,
                                   .per_frame = c.per_frame,
                                   .per_byte = c.per_byte,
                                   .tolerance = c.tolerance,
                                   .pad = {}};
  return use.number;
}

void EtherTable::leave_contract(std::uint16_t number) {
  const ether_contract& c = memory_.contracts[number];
  const auto at = contracts_.find(Contract{c.uid, c.source, c.station_high, c.max_len, c.forms,
                                           c.per_frame, c.per_byte, c.tolerance});
  if (--at->second.slots != 0) return;
  contracts_.erase(at);
  contract_numbers_.quarantine.push_back(number);
}

/// The last slot with a stated station in the chain of the bucket. A wildcard slot is linked after
/// it; 0: it is linked first.
std::uint32_t EtherTable::last_of_stations(std::uint64_t bucket, const SlotSpec& spec) const {
  std::uint32_t last = 0;
  if (spec.station != 0) return last;
  for (auto at = static_cast<std::uint32_t>(bucket); at != 0; at = memory_.slots[at].next)
    if (station_of(at) != 0) last = at;
  return last;
}

void EtherTable::link(const SlotSpec& spec) {
  const std::uint32_t slot = slots_.free.back();
  slots_.free.pop_back();
  for (std::size_t bank = 0; bank < sizes_.banks; ++bank)
    memory_.counts[bank * sizes_.slots + slot] = {};
  memory_.audits[slot] = {};
  const std::uint64_t hash = hash_of(spec.subject, spec.direction);
  std::uint64_t& bucket = bucket_of(hash);
  const std::uint32_t before = last_of_stations(bucket, spec);
  memory_.slots[slot] = {
      .subject = spec.subject,
      .due = 0,
      .next = before == 0 ? static_cast<std::uint32_t>(bucket) : memory_.slots[before].next,
      .station = static_cast<std::uint32_t>(spec.station),
      .contract = take_contract(spec),
      .verdict = {GATE_DENY, GATE_DENY},
      .direction = std::to_underlying(spec.direction),
      .last_reason = GATE_R_PASSED,
      .watch = 0};
  set_watch(slot, spec);
  if (std::uint8_t* prefilter = prefilter_at(hash); prefilter != nullptr)
    publish(*prefilter, static_cast<__u8>(*prefilter | ether_prefilter_bits(hash)));
  const std::uint64_t fingerprints = bucket >> ETHER_FINGERPRINT_SHIFT << ETHER_FINGERPRINT_SHIFT;
  const std::uint64_t first = before == 0 ? slot : static_cast<std::uint32_t>(bucket);
  publish(bucket, std::uint64_t{fingerprints | ether_fingerprint(hash) | first});
  if (before != 0) publish(memory_.slots[before].next, slot);
  ++used_;
  core::Progress::step();
}

std::uint64_t EtherTable::fingerprints_of(std::uint32_t first) const {
  std::uint64_t fingerprints = 0;
  for (std::uint32_t at = first; at != 0; at = memory_.slots[at].next)
    fingerprints |= ether_fingerprint(hash_at(at));
  return fingerprints;
}

std::uint8_t EtherTable::prefilter_of(std::uint32_t first) const {
  std::uint8_t bits = 0;
  for (std::uint32_t at = first; at != 0; at = memory_.slots[at].next)
    bits |= ether_prefilter_bits(hash_at(at));
  return bits;
}

/// The slot keeps its `next`, so that a program that reads it finds the rest of the chain.
void EtherTable::unlink(const SlotSpec& spec) {
  const auto found = find(spec);
  if (!found) return;
  const ether_slot& slot = memory_.slots[*found];
  const std::uint64_t hash = hash_of(spec.subject, spec.direction);
  std::uint64_t& bucket = bucket_of(hash);
  auto first = static_cast<std::uint32_t>(bucket);
  if (first == *found) {
    first = slot.next;
  } else {
    std::uint32_t before = first;
    while (memory_.slots[before].next != *found) before = memory_.slots[before].next;
    publish(memory_.slots[before].next, slot.next);
  }
  publish(bucket, fingerprints_of(first) | first);
  if (std::uint8_t* prefilter = prefilter_at(hash); prefilter != nullptr)
    publish(*prefilter, prefilter_of(first));
  leave_contract(slot.contract);
  leave_watch(*found);
  slots_.quarantine.push_back(*found);
  --used_;
  core::Progress::step();
}

void EtherTable::set_traffic(const SlotSpec& spec) {
  const auto found = find(spec);
  if (!found) return;
  ether_slot& slot = memory_.slots[*found];
  const std::uint16_t before = slot.contract;
  const SlotSpec former = spec_of(*found);
  publish(slot.contract, take_contract(spec));
  leave_contract(before);
  // Turns that were reserved at the former rate have no meaning at the new one.
  if (former.per_frame != spec.per_frame || former.per_byte != spec.per_byte ||
      former.tolerance != spec.tolerance)
    publish(slot.due, __u64{0});
  set_watch(*found, spec);
  note_watched(*found);
  core::Progress::step();
}

// --- checks of a change before it is made --------------------------------------------------------

Result<void> EtherTable::check(const SlotChanges& changes) const {
  if (auto good = check_adds(changes.add); !good) return good;
  for (const auto* list : {&changes.close, &changes.remove, &changes.open, &changes.police})
    for (const auto& s : *list) {
      if (!find(s)) return fail(name(s) + " is not there");
      core::Progress::step();
    }
  if (auto good = check_once(changes.remove); !good) return good;
  const auto removed = sorted(changes.remove);
  for (const auto& s : changes.open) {
    core::Progress::step();
    if (std::ranges::binary_search(removed, &s, [](const SlotSpec* a, const SlotSpec* b) {
          return grant(*a) < grant(*b);
        }))
      return fail(name(s) + " is to be opened and removed");
  }
  return check_room(changes);
}

Result<void> EtherTable::check_adds(const std::vector<SlotSpec>& adds) const {
  for (const auto& s : adds) {
    if (auto good = check_spec(s); !good) return good;
    if (find(s)) return fail(name(s) + " is there already");
    core::Progress::step();
  }
  return check_once(adds);
}

/// Checks the state after the changes.
Result<void> EtherTable::check_room(const SlotChanges& changes) const {
  const std::size_t room = sizes_.slots - ETHER_FIRST_SLOT;
  if (used_ + changes.add.size() - changes.remove.size() > room)
    return fail(fmt::format("more than {} slots on one interface", room));
  if (auto good = check_publishers(changes); !good) return good;
  if (auto good = check_contracts(changes); !good) return good;
  return check_chains(changes, true);
}

/// Checks the state after the changes, or with `removed_first` false the state in which old and new
/// slots are side by side.
Result<void> EtherTable::check_chains(const SlotChanges& changes, bool removed_first) const {
  const auto buckets = [&](const std::vector<SlotSpec>& specs) {
    std::vector<std::uint64_t> out;
    out.reserve(specs.size());
    for (const auto& s : specs)
      out.push_back(hash_of(s.subject, s.direction) & (sizes_.buckets - 1));
    std::ranges::sort(out);
    core::Progress::made();
    return out;
  };
  const auto added = buckets(changes.add);
  const auto removed = removed_first ? buckets(changes.remove) : std::vector<std::uint64_t>{};
  for (auto run = added.begin(); run != added.end();) {
    core::Progress::step();
    const auto end = std::upper_bound(run, added.end(), *run);
    const auto gone = std::ranges::equal_range(removed, *run);
    std::ptrdiff_t slots = end - run - std::ssize(gone);
    for (auto at = static_cast<std::uint32_t>(memory_.buckets[*run]); at != 0;
         at = memory_.slots[at].next)
      ++slots;
    if (slots > GATE_WALK)
      return fail(fmt::format("more than {} slots whose subjects fall together", GATE_WALK));
    run = end;
  }
  return {};
}

/// Removed slots leave their contracts before others are needed. A slot whose traffic changes takes
/// the new contract before it leaves the old one.
Result<void> EtherTable::check_contracts(const SlotChanges& changes) const {
  const std::size_t room = sizes_.contracts - 1;
  std::size_t all = contracts_.size() + new_contracts(changes).size();
  if (all <= room) return {};
  std::map<std::uint16_t, std::uint32_t> left;
  for (const auto& s : changes.remove) {
    if (const auto slot = find(s)) ++left[memory_.slots[*slot].contract];
    core::Progress::step();
  }
  std::set<Contract> kept;
  for (const auto* list : {&changes.add, &changes.police})
    for (const auto& s : *list) {
      kept.insert(contract_of(s));
      core::Progress::step();
    }
  for (const auto& [contract, use] : contracts_)
    if (const auto gone = left.find(use.number);
        gone != left.end() && gone->second == use.slots && !kept.contains(contract))
      --all;
  if (all <= room) return {};
  return fail(
      fmt::format("more than {} different contracts (user, length, rate) on one interface", room));
}

Result<void> EtherTable::check_publishers(const SlotChanges& changes) const {
  const auto added = sorted(changes.add);
  const auto removed = sorted(changes.remove);
  const auto by_key = [](const SlotSpec* s) { return key(*s); };
  for (auto run = added.begin(); run != added.end();) {
    core::Progress::step();
    const auto end =
        std::find_if(run, added.end(), [&](const SlotSpec* s) { return key(*s) != key(**run); });
    const auto gone = std::ranges::equal_range(removed, key(**run), {}, by_key);
    std::ptrdiff_t publishers = end - run - std::ssize(gone);
    const std::uint64_t bucket = bucket_of(hash_of((*run)->subject, (*run)->direction));
    for (auto at = static_cast<std::uint32_t>(bucket); at != 0; at = memory_.slots[at].next)
      publishers +=
          memory_.slots[at].subject == (*run)->subject && key(spec_of(at)) == key(**run) ? 1 : 0;
    if (publishers > ETHER_CHAIN)
      return fail(
          fmt::format("{}: more than {} publishers of this subject", name(**run), ETHER_CHAIN));
    run = end;
  }
  return {};
}

// --- supervised slots ----------------------------------------------------------------------------

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

}  // namespace mlcca::gates
