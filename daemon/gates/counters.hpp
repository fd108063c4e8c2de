// SPDX-License-Identifier: BSD-2-Clause
// Reads what the gate of one interface has counted: each CPU counts for itself, the sums are made
// here. No system calls.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bpf/ether.h"
#include "bpf/gate.h"
#include "daemon/gates/ether_table.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

struct SlotCounters {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t bytes = 0;         ///< payload bytes passed
  std::uint64_t excess = 0;        ///< more than admitted, dropped or admitted all the same
  std::uint64_t would_drop = 0;    ///< let through by audit mode, part of nothing above
  std::uint64_t would_exceed = 0;  ///< part of would_drop: more than admitted
  gate_reason last_reason = GATE_R_PASSED;  ///< of the latest drop, or of what would be one
};

/// Frames of one direction by enum gate_reason; what audit mode lets through is counted apart.
using ReasonCounters = std::array<std::uint64_t, GATE_REASONS>;

using Mac = std::array<std::uint8_t, 6>;

struct UnknownFrame {
  std::uint32_t can_id = 0;   ///< with the flags of <linux/can.h>; 0 on Ethernet
  std::uint64_t subject = 0;  ///< on Ethernet
  std::uint16_t len = 0;      ///< payload bytes of the latest
  std::uint8_t format = 0;    ///< GATE_CLASSIC, GATE_FD or GATE_XL
  Direction direction = Direction::ingress;
  std::uint64_t count = 0;     ///< at least; a rarer one may have taken its place meanwhile
  std::uint64_t sequence = 0;  ///< grows with every unknown frame of the interface
  std::uint64_t station = 0;   ///< on Ethernet: sender of the latest, as ether_station()
  Mac mac = {};                ///< of the Ethernet frame it was in; 0: not read
};

/// "10.0.0.7" of a station that has an IPv4 address, or one of 802.15.4; "" of others.
std::string address_text(std::uint64_t station);
/// "02:00:5e:10:00:01" of the sender: the station's own, else that of the frame; "" where none.
std::string mac_text(std::uint64_t station, const Mac& mac);
/// "10.0.0.7 (02:00:5e:10:00:01)", as much of it as is known.
std::string sender_text(std::uint64_t station, const Mac& mac);

SlotCounters slot_counters(const gate_table& table, std::span<const gate_cpu> cpus,
                           std::uint32_t slot);
SlotCounters ether_counters(const EtherMemory& memory, std::uint32_t slot);
ReasonCounters reason_counters(std::span<const gate_cpu> cpus, Direction direction);
ReasonCounters reason_counters(std::span<const ether_cpu> cpus, Direction direction);
/// What audit mode has let through, of either kind of table.
template <class Table>
ReasonCounters would_drop_counters(const Table& table, Direction direction) {
  ReasonCounters out{};
  for (std::size_t reason = 0; reason < GATE_REASONS; ++reason)
    out.at(reason) =
        __atomic_load_n(&table.would_drop[std::to_underlying(direction)][reason], __ATOMIC_RELAXED);
  return out;
}
/// Frames without a slot, newest first.
std::vector<UnknownFrame> unknown_frames(std::span<const gate_cpu> cpus);
std::vector<UnknownFrame> unknown_frames(std::span<const ether_cpu> cpus);

/// "unknown subject", "not from the granted source": one line for a person.
const char* reason_text(gate_reason reason);
/// Whether the reason means a drop (GATE_R_PASSED, _ECHO, _ERROR_IN and _FOREIGN do not).
bool is_drop(gate_reason reason);

}  // namespace mlcca::enforce
