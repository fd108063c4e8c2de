// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/bindings.hpp"

#include <algorithm>
#include <atomic>
#include <unordered_map>

#include "daemon/gates/publish.hpp"

namespace mlcca::gates {
namespace {

template <class T>
T load(const T& at) {
  return __atomic_load_n(&at, __ATOMIC_RELAXED);
}

bool is_contradicted(const gate_binding& b) { return load(b.contradictions) != load(b.settled); }

/// The slots of control traffic have no subject of their own.
bool is_of(const gate_slot& slot, const gate_binding& b) {
  return slot.subject == b.subject || (slot.subject == 0 && b.subject == GATE_SUBSCRIBE);
}

/// Fills a binding that no program reads before its subject is set.
void fill(gate_binding& b, const StatedBinding& stated) {
  b.other = 0;
  b.contradictions = stated.contradicted ? 1 : 0;
  b.settled = 0;
  b.confirmed = 0;
  b.dealt = stated.dealt;
  b.halves = 0;
  publish(b.etag, __u16{stated.etag});
  publish(b.subject, __u64{stated.subject});
}

/// Gives a binding another tag while the program may read it and add to `contradictions`.
void give(gate_binding& b, std::uint16_t etag, std::uint32_t settled) {
  publish(b.settled, __u32{settled});
  publish(b.etag, __u16{etag});
}

/// Updates a binding that is in the table and may get another tag.
void restate(gate_binding& b, const StatedBinding& stated) {
  if (b.etag == stated.etag) return;
  if (load(b.dealt) == 0 && stated.etag == 0) publish(b.dealt, __u16{stated.dealt});
  give(b, stated.etag, load(b.contradictions));
}

}  // namespace

std::span<gate_binding> Bindings::used() const {
  return std::span(table_->bindings)
      .first(std::min<std::size_t>(table_->bindings_end, GATE_BINDINGS));
}

gate_binding* Bindings::find(std::uint64_t subject) const {
  const auto all = used();
  const auto it = std::ranges::find(all, subject, &gate_binding::subject);
  return it == all.end() ? nullptr : &*it;
}

void Bindings::state(std::span<const StatedBinding> bindings) {
  std::unordered_map<std::uint64_t, const StatedBinding*> wanted;
  for (const StatedBinding& b : bindings) wanted.emplace(b.subject, &b);
  for (gate_binding& b : used()) {
    const auto it = b.subject == 0 ? wanted.end() : wanted.find(b.subject);
    if (it == wanted.end()) {
      publish(b.subject, __u64{0});
      continue;
    }
    restate(b, *it->second);
    wanted.erase(it);
  }
  std::size_t at = 0;
  for (const StatedBinding& b : bindings) {
    if (!wanted.contains(b.subject)) continue;
    while (at < GATE_BINDINGS && table_->bindings[at].subject != 0) ++at;
    if (at == GATE_BINDINGS) return;
    fill(table_->bindings[at], b);
    if (at >= table_->bindings_end) publish(table_->bindings_end, static_cast<__u32>(at + 1));
    mark_slots(table_->bindings[at], b.contradicted ? 1 : 0);
  }
}

void Bindings::move(const FoundBinding& seen, std::uint16_t etag) {
  if (gate_binding* const b = find(seen.subject)) give(*b, etag, seen.contradictions);
}

std::uint32_t Bindings::news() const { return load(table_->binding_news); }

std::vector<FoundBinding> Bindings::found() const {
  std::vector<FoundBinding> out;
  for (const gate_binding& b : used()) {
    if (b.subject == 0) continue;
    const std::uint32_t contradictions = load(b.contradictions);
    // The program counts a contradiction after it has taken the tag back.
    std::atomic_thread_fence(std::memory_order_acquire);
    const bool contradicted = contradictions != load(b.settled);
    out.push_back({.subject = b.subject,
                   .etag = b.etag,
                   .contradicted = contradicted,
                   .confirmed = contradicted && load(b.confirmed) == contradictions,
                   .dealt = load(b.dealt),
                   .other = load(b.other),
                   .halves = load(b.halves),
                   .contradictions = contradictions});
  }
  return out;
}

void Bindings::mark_slots(const gate_binding& binding, std::uint8_t contradicted) const {
  for (const auto& heads : table_->head)
    for (std::uint16_t at = load(heads[binding.etag & GATE_ETAG_MASK]); at != 0;
         at = table_->slots[at].next)
      if (is_of(table_->slots[at], binding)) publish(table_->slots[at].contradicted, contradicted);
}

bool Bindings::end_contradictions(std::uint64_t subject) {
  gate_binding* const b = find(subject);
  if (b == nullptr) return false;
  const std::uint32_t so_far = load(b->contradictions);
  publish(b->settled, so_far);
  mark_slots(*b, 0);
  std::atomic_thread_fence(std::memory_order_seq_cst);
  if (load(b->contradictions) == so_far) return true;
  mark_slots(*b, 1);
  return false;
}

bool Bindings::is_contradicted(const gate_slot& slot) const {
  std::atomic_thread_fence(std::memory_order_seq_cst);
  return std::ranges::any_of(used(), [&](const gate_binding& b) {
    return b.subject != 0 && b.etag == (slot.id & GATE_ETAG_MASK) && is_of(slot, b) &&
           gates::is_contradicted(b);
  });
}

}  // namespace mlcca::gates
