// SPDX-License-Identifier: BSD-2-Clause
// Reads the counters of the gate of one interface. Each CPU counts separately, and the sums are
// made here. No system calls.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bpf/ether.h"
#include "bpf/gate.h"
#include "core/gates/frame_reason.hpp"
#include "daemon/gates/ether_table.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

/// The counters of one slot, summed over all CPUs.
struct SlotCounters {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t bytes = 0;         ///< payload bytes passed
  std::uint64_t excess = 0;        ///< frames beyond the admitted traffic, dropped or passed
  std::uint64_t would_drop = 0;    ///< passed in audit mode; not a part of the others
  std::uint64_t would_exceed = 0;  ///< the part of would_drop that is excess
  /// Of the latest real or audit-mode drop; `passed`: nothing was dropped yet.
  core::FrameReason last_reason = core::FrameReason::passed;
};

/// Frames of one direction, indexed by enum gate_reason. Frames that pass in audit mode are counted
/// separately.
using ReasonCounters = std::array<std::uint64_t, GATE_REASONS>;

using Mac = std::array<std::uint8_t, 6>;

/// A kind of frame without a slot, as the gate has seen it.
struct UnknownFrame {
  std::uint32_t can_id = 0;   ///< with the flags of <linux/can.h>; 0 on Ethernet
  std::uint64_t subject = 0;  ///< on Ethernet
  std::uint16_t len = 0;      ///< payload bytes of the latest frame
  std::uint8_t format = 0;    ///< GATE_CLASSIC, GATE_FD or GATE_XL
  Direction direction = Direction::ingress;
  std::uint64_t count = 0;     ///< a lower bound: a rarer kind may have taken its place meanwhile
  std::uint64_t sequence = 0;  ///< increases with every unknown frame of the interface
  std::uint64_t station = 0;   ///< on Ethernet: the sender of the latest frame, as ether_station()
  Mac mac = {};                ///< source of the Ethernet frame of the latest; 0: not read
};

/// A sender whose frames a slot refused because they are not the granted sender's, as one CPU has
/// counted it. Or one whose frames belong to no slot, for example because they are malformed.
struct RefusedSender {
  std::size_t place = 0;  ///< in the memory of the gate; another sender may take it later
  std::uint32_t slot = 0;
  core::FrameReason reason = core::FrameReason::source;  ///< of a slot `identifier` or `source`
  /// Its latest frame, as one without a slot. If it is malformed, `len` has all its bytes, and
  /// `format` and `subject` are 0 where they could not be read.
  UnknownFrame frame;
  std::uint32_t source = 0;  ///< at egress: as in gate_slot
  std::uint32_t uid = 0;     ///< at egress: user of a local sender; otherwise GATE_ANY_UID

  /// Whether its frames belong to no slot: those numbers count such frames.
  [[nodiscard]] bool is_without_slot() const { return slot < GATE_FIRST_SLOT; }
};
/// Whether both are of the same sender.
bool is_same(const RefusedSender& one, const RefusedSender& other);
static_assert(GATE_FIRST_SLOT == ETHER_FIRST_SLOT);

/// The address of a station that has an IPv4 address ("10.0.0.7") or one of 802.15.4; "" for
/// others.
std::string address_text(std::uint64_t station);
/// The MAC address of the sender ("02:00:5e:10:00:01"): the station's own, or else that of the
/// frame; "" if there is none.
std::string mac_text(std::uint64_t station, const Mac& mac);
/// Both addresses, as far as known: "10.0.0.7 (02:00:5e:10:00:01)".
std::string sender_text(std::uint64_t station, const Mac& mac);

SlotCounters slot_counters(const gate_table& table, std::span<const gate_cpu> cpus,
                           std::uint32_t slot);
SlotCounters ether_counters(const EtherMemory& memory, std::uint32_t slot);
ReasonCounters reason_counters(std::span<const gate_cpu> cpus, Direction direction);
ReasonCounters reason_counters(std::span<const ether_cpu> cpus, Direction direction);
/// Frames that passed in audit mode, by the reason for which they would have been dropped. For
/// either kind of table.
template <class Table>
ReasonCounters would_drop_counters(const Table& table, Direction direction) {
  ReasonCounters out{};
  for (std::size_t reason = 0; reason < GATE_REASONS; ++reason)
    out.at(reason) =
        __atomic_load_n(&table.would_drop[std::to_underlying(direction)][reason], __ATOMIC_RELAXED);
  return out;
}
/// The frames without a slot, the newest first.
std::vector<UnknownFrame> unknown_frames(std::span<const gate_cpu> cpus);
std::vector<UnknownFrame> unknown_frames(std::span<const ether_cpu> cpus);
/// The senders of refused frames, in the order of their places, at most GATE_SENDERS for each
/// CPU.
std::vector<RefusedSender> refused_senders(std::span<const gate_cpu> cpus);
std::vector<RefusedSender> refused_senders(std::span<const ether_cpu> cpus);

/// The reason with that number, of which the kernel counts the lowest bits, too.
constexpr core::FrameReason reason_of(std::size_t number) {
  return static_cast<core::FrameReason>(number % GATE_REASONS);
}
static_assert(core::kFrameReasons.size() == GATE_REASONS);

}  // namespace mlcca::gates
