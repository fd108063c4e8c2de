// SPDX-License-Identifier: BSD-2-Clause
// Sums over CPUs and banks. The kernel writes meanwhile, so each number is read once, in one load.
#include "daemon/gates/counters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace mlcca::gates {
namespace {

/// Attempts to read an entry between two frames of its sender, which may come one after the other.
constexpr int kReadTries = 8;

template <class T>
T load(const T& word, int order = __ATOMIC_RELAXED) {
  return __atomic_load_n(&word, order);
}

/// What distinguishes frames of an entry from others: of CAN, or of Ethernet.
void read_words(const auto& seen, UnknownFrame& frame) {
  if constexpr (requires { seen.can_id; }) {
    frame.can_id = load(seen.can_id);
    frame.format = load(seen.format);
  } else {
    frame.subject = load(seen.subject);
    frame.station = load(seen.station);
    for (std::size_t i = 0; i < frame.mac.size(); ++i) frame.mac.at(i) = load(seen.mac[i]);
  }
}

/// nullopt if the entry is empty, or was overwritten while it was read.
std::optional<UnknownFrame> read(const auto& seen) {
  UnknownFrame frame;
  frame.sequence = load(seen.sequence, __ATOMIC_ACQUIRE);
  frame.len = static_cast<std::uint16_t>(load(seen.len));
  frame.direction = static_cast<Direction>(load(seen.direction));
  frame.count = load(seen.count);
  read_words(seen, frame);
  std::atomic_thread_fence(std::memory_order_acquire);
  if (frame.sequence == 0 || load(seen.sequence) != frame.sequence) return std::nullopt;
  return frame;
}

void add(SlotCounters& sum, const gate_count& count) {
  sum.passed += load(count.passed);
  sum.dropped += load(count.dropped);
  sum.bytes += load(count.bytes);
  sum.excess += load(count.excess);
}

void take(SlotCounters& sum, const gate_audit& audit, const __u8& last_reason) {
  sum.would_drop = load(audit.would_drop);
  sum.would_exceed = load(audit.would_exceed);
  sum.last_reason = reason_of(load(last_reason));
}

template <class Cpu>
ReasonCounters sum_of_reasons(std::span<const Cpu> cpus, Direction direction) {
  ReasonCounters sum{};
  for (const auto& cpu : cpus)
    for (std::size_t reason = 0; reason < GATE_REASONS; ++reason)
      sum.at(reason) += load(cpu.reasons[std::to_underlying(direction)][reason]);
  return sum;
}

/// Merges the same kind of frame on several CPUs, with the values of the latest.
template <class Cpu>
std::vector<UnknownFrame> newest_of(std::span<const Cpu> cpus) {
  // NOLINTNEXTLINE(misc-const-correctness): the check does not see in a template that it changes
  std::map<std::tuple<std::uint32_t, std::uint64_t, std::uint8_t, Direction>, UnknownFrame> merged;
  for (const auto& cpu : cpus) {
    for (const auto& seen : cpu.seen) {
      // A second attempt suffices: the writer finishes within nanoseconds.
      auto frame = read(seen);
      if (!frame) frame = read(seen);
      if (!frame) continue;
      UnknownFrame& sum = merged[{frame->can_id, frame->subject, frame->format, frame->direction}];
      const std::uint64_t count = frame->count + sum.count;
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

/// The words beside the frame are read before it, so that they are the entry's if its sequence has
/// not changed.
std::optional<RefusedSender> read_sender(const auto& seen) {
  const std::uint64_t sequence = load(seen.sequence, __ATOMIC_ACQUIRE);
  RefusedSender sender{.slot = load(seen.slot),
                       .reason = reason_of(load(seen.reason)),
                       .frame = {},
                       .source = load(seen.source),
                       .uid = load(seen.uid)};
  const auto frame = read(seen);
  if (!frame) return std::nullopt;
  std::atomic_thread_fence(std::memory_order_acquire);
  if (load(seen.sequence) != sequence) return std::nullopt;
  sender.frame = *frame;
  return sender;
}

template <class Cpu>
std::vector<RefusedSender> senders_of(std::span<const Cpu> cpus) {
  std::vector<RefusedSender> out;
  std::size_t place = 0;
  for (const auto& cpu : cpus)
    for (const auto& seen : cpu.senders) {
      const std::size_t at = place++;
      if (load(seen.sequence) == 0) continue;
      std::optional<RefusedSender> sender;
      for (int i = 0; i < kReadTries && !sender; ++i) sender = read_sender(seen);
      if (!sender) continue;
      sender->place = at;
      out.push_back(*sender);
    }
  return out;
}

/// For example "02:00:5e:10:00:01".
std::string octets_text(std::uint64_t number, std::size_t octets) {
  std::string out;
  while (octets-- > 0)
    out += fmt::format("{}{:02x}", out.empty() ? "" : ":", number >> 8 * octets & 0xff);
  return out;
}

}  // namespace

SlotCounters slot_counters(const gate_table& table, std::span<const gate_cpu> cpus,
                           std::uint32_t slot) {
  SlotCounters sum;
  for (const auto& cpu : cpus) add(sum, cpu.slots[slot]);
  take(sum, table.audit[slot], table.last_reason[slot]);
  return sum;
}
SlotCounters ether_counters(const EtherMemory& memory, std::uint32_t slot) {
  SlotCounters sum;
  for (std::size_t at = slot; at < memory.counts.size(); at += memory.slots.size())
    add(sum, memory.counts[at]);
  take(sum, memory.audits[slot], memory.slots[slot].last_reason);
  return sum;
}

ReasonCounters reason_counters(std::span<const gate_cpu> cpus, Direction direction) {
  return sum_of_reasons(cpus, direction);
}
ReasonCounters reason_counters(std::span<const ether_cpu> cpus, Direction direction) {
  return sum_of_reasons(cpus, direction);
}

std::vector<UnknownFrame> unknown_frames(std::span<const gate_cpu> cpus) { return newest_of(cpus); }
std::vector<UnknownFrame> unknown_frames(std::span<const ether_cpu> cpus) {
  return newest_of(cpus);
}

std::vector<RefusedSender> refused_senders(std::span<const gate_cpu> cpus) {
  return senders_of(cpus);
}
std::vector<RefusedSender> refused_senders(std::span<const ether_cpu> cpus) {
  return senders_of(cpus);
}

bool is_same(const RefusedSender& one, const RefusedSender& other) {
  const auto identity_of = [](const RefusedSender& sender) {
    const UnknownFrame& f = sender.frame;
    return std::tie(sender.slot, sender.reason, sender.source, sender.uid, f.can_id, f.format,
                    f.direction, f.subject, f.station, f.mac);
  };
  return identity_of(one) == identity_of(other);
}

std::string address_text(std::uint64_t station) {
  if ((station & ETHER_EXTENDED) != 0) return octets_text(station & ~ETHER_EXTENDED, 8);
  if ((station & ETHER_SHORT) != 0)
    return fmt::format("{:#06x}:{:#06x}", station >> 16 & 0xffff, station & 0xffff);
  if (station == 0 || (station & ETHER_MAC) != 0) return {};
  return fmt::format("{}.{}.{}.{}", station >> 24 & 0xff, station >> 16 & 0xff, station >> 8 & 0xff,
                     station & 0xff);
}

std::string mac_text(std::uint64_t station, const Mac& mac) {
  if (station >= ETHER_MAC && station < ETHER_SHORT)
    return octets_text(station & ~ETHER_MAC, mac.size());
  return mac == Mac{} ? "" : fmt::format("{:02x}", fmt::join(mac, ":"));
}

std::string sender_text(std::uint64_t station, const Mac& mac) {
  const std::string address = address_text(station);
  const std::string hardware = mac_text(station, mac);
  if (address.empty() || hardware.empty()) return address + hardware;
  return fmt::format("{} ({})", address, hardware);
}

}  // namespace mlcca::gates
