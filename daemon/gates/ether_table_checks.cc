// SPDX-License-Identifier: BSD-2-Clause
// Checks of changes of an Ethernet table before any is made: see Table::apply().
#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/model/progress.hpp"
#include "daemon/gates/ether_table.hpp"

namespace mlcca::enforce {
namespace {

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
}  // namespace mlcca::enforce
