// SPDX-License-Identifier: BSD-2-Clause
// Reads what the gate of one interface has counted: each CPU counts for itself, the sums are made
// here. No system calls.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bpf/gate.h"
#include "daemon/enforce/slots.hpp"

namespace mlcca::enforce {

struct SlotCounters {
  std::uint64_t passed = 0;
  std::uint64_t dropped = 0;                ///< in audit mode: would have been dropped
  std::uint64_t bytes = 0;                  ///< payload bytes passed
  std::uint64_t excess = 0;                 ///< more than admitted, dropped or not
  gate_reason last_reason = GATE_R_PASSED;  ///< of the latest drop
};

/// Frames of one direction by enum gate_reason.
using ReasonCounters = std::array<std::uint64_t, GATE_REASONS>;

struct UnknownFrame {
  std::uint32_t can_id = 0;   ///< with the flags of <linux/can.h>; 0 on Ethernet
  std::uint64_t subject = 0;  ///< on Ethernet
  std::uint16_t len = 0;      ///< payload bytes of the latest
  std::uint8_t format = 0;    ///< GATE_CLASSIC, GATE_FD or GATE_XL
  Direction direction = Direction::ingress;
  std::uint64_t count = 0;     ///< at least; a rarer one may have taken its place meanwhile
  std::uint64_t sequence = 0;  ///< grows with every unknown frame of the interface
};

SlotCounters slot_counters(const gate_table& table, std::span<const gate_cpu> cpus,
                           std::uint16_t slot);
ReasonCounters reason_counters(std::span<const gate_cpu> cpus, Direction direction);
/// Frames without a slot, newest first.
std::vector<UnknownFrame> unknown_frames(std::span<const gate_cpu> cpus);

/// "unknown subject", "not from the granted source": one line for a person.
const char* reason_text(gate_reason reason);
/// Whether the reason means a drop (GATE_R_PASSED, _ECHO, _ERROR_IN and _FOREIGN do not).
bool is_drop(gate_reason reason);

}  // namespace mlcca::enforce
