// SPDX-License-Identifier: BSD-2-Clause
// Selects frames that prove the content of a CAN gate, with their expected fate. No I/O.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/gates/readback.hpp"

namespace mlcca::readback {

/// A frame and the way on which it reaches a gate.
struct Probe {
  enum class Way : std::uint8_t {
    in,       ///< from the bus
    out,      ///< sent by a program on this machine
    through,  ///< forwarded from the bus at interface `source`
  };
  Way way = Way::in;
  std::uint32_t id = 0;  ///< with the flags of <linux/can.h>
  std::uint16_t len = 0;
  bool fd = false;
  std::uint32_t source = 0;  ///< interface index; only for `through`
  std::uint32_t uid = 0;     ///< of the program that sends it; only for `out`

  auto operator<=>(const Probe&) const = default;
};

/// The frames for one gate.
struct Probes {
  std::vector<Probe> frames;  ///< sorted, without duplicates
  std::size_t untried = 0;    ///< number of slots that no frame of ours can reach
};

/// For every slot a frame that fits and one that is too long, and a frame with a key without a
/// slot. Slots only for CAN XL and slots for frames that the kernel itself sends cannot be tried.
Probes probes_for(const gates::GateReading& gate);

/// Whether the gates should pass the frame while they are open.
bool is_admitted(const Probe& probe, const gates::GateReading& gate,
                 std::span<const gates::GateReading> all);

/// Whether the frame is forwarded and may leave through the gate, but enters with another
/// identifier if at all. Only its drop at the ingress can be shown then.
bool enters_otherwise(const Probe& probe, const gates::GateReading& gate,
                      std::span<const gates::GateReading> all);

/// A text such as "1ABCDEF0#, 8 bytes from the bus".
std::string to_text(const Probe& probe);

}  // namespace mlcca::readback
