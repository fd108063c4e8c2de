// SPDX-License-Identifier: BSD-2-Clause
// Sums over banks and CPUs. The kernel writes meanwhile: each number is read once and whole.
#include "daemon/gates/ether_counters.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <utility>

namespace mlcca::enforce {
namespace {

template <class T>
T load(const T& word, int order = __ATOMIC_RELAXED) {
  return __atomic_load_n(&word, order);
}

/// Nothing when the entry is empty or changed hands while it was read.
std::optional<UnknownFrame> read(const ether_seen& seen) {
  UnknownFrame frame;
  frame.sequence = load(seen.sequence, __ATOMIC_ACQUIRE);
  frame.subject = load(seen.subject);
  frame.len = static_cast<std::uint16_t>(load(seen.len));
  frame.direction = static_cast<Direction>(load(seen.direction));
  frame.count = load(seen.count);
  frame.station = load(seen.station);
  for (std::size_t i = 0; i < frame.mac.size(); ++i) frame.mac.at(i) = load(seen.mac[i]);
  std::atomic_thread_fence(std::memory_order_acquire);
  if (frame.sequence == 0 || load(seen.sequence) != frame.sequence) return std::nullopt;
  return frame;
}

}  // namespace

SlotCounters ether_counters(const EtherMemory& memory, std::uint32_t slot) {
  SlotCounters sum;
  for (std::size_t at = slot; at < memory.counts.size(); at += memory.slots.size()) {
    sum.passed += load(memory.counts[at].passed);
    sum.dropped += load(memory.counts[at].dropped);
    sum.bytes += load(memory.counts[at].bytes);
    sum.excess += load(memory.counts[at].excess);
  }
  sum.would_drop = load(memory.audits[slot].would_drop);
  sum.would_exceed = load(memory.audits[slot].would_exceed);
  sum.last_reason = static_cast<gate_reason>(load(memory.slots[slot].last_reason));
  return sum;
}

ReasonCounters ether_reasons(std::span<const ether_cpu> cpus, Direction direction) {
  ReasonCounters sum{};
  for (const auto& cpu : cpus)
    for (std::size_t reason = 0; reason < GATE_REASONS; ++reason)
      sum.at(reason) += load(cpu.reasons[std::to_underlying(direction)][reason]);
  return sum;
}

std::vector<UnknownFrame> unknown_subjects(std::span<const ether_cpu> cpus) {
  std::map<std::pair<std::uint64_t, Direction>, UnknownFrame> merged;
  for (const auto& cpu : cpus) {
    for (const auto& seen : cpu.seen) {
      // A second try: the writer is done within nanoseconds.
      auto frame = read(seen);
      if (!frame) frame = read(seen);
      if (!frame) continue;
      UnknownFrame& sum = merged[{frame->subject, frame->direction}];
      frame->count += sum.count;
      const std::uint64_t count = frame->count;
      if (frame->sequence > sum.sequence) sum = *frame;
      sum.count = count;
    }
  }
  std::vector<UnknownFrame> newest;
  newest.reserve(merged.size());
  for (const auto& [key, frame] : merged) newest.push_back(frame);
  std::ranges::sort(newest, std::ranges::greater{}, &UnknownFrame::sequence);
  return newest;
}

}  // namespace mlcca::enforce
