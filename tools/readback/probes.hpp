// SPDX-License-Identifier: BSD-2-Clause
// Which frames prove what a CAN gate holds, and what must become of them. Pure.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/gates/readback.hpp"

namespace mlcca::readback {

/// A frame, and how it comes to a gate.
struct Probe {
  enum class Way : std::uint8_t {
    in,       ///< from the bus
    out,      ///< sent by a program on this machine
    through,  ///< from the bus behind `source`, forwarded
  };
  Way way = Way::in;
  std::uint32_t id = 0;  ///< with the flags of <linux/can.h>
  std::uint16_t len = 0;
  bool fd = false;
  std::uint32_t source = 0;  ///< ifindex; `through` only
  std::uint32_t uid = 0;     ///< of the program; `out` only

  auto operator<=>(const Probe&) const = default;
};

struct Probes {
  std::vector<Probe> frames;  ///< sorted, each once
  std::size_t untried = 0;    ///< slots that no frame of ours can reach
};

/// For every slot a frame that fits it and one that is longer; and one with a key without a slot.
/// Out of reach are slots for CAN XL alone and for what the kernel itself sends.
Probes probes_for(const enforce::GateReading& gate);

/// What the gates let pass while they are open, one frame at a time.
bool is_admitted(const Probe& probe, const enforce::GateReading& gate,
                 std::span<const enforce::GateReading> all);

/// A forwarded frame that the gate lets leave, and that enters by another identifier if at all:
/// only its drop at the way in can be shown.
bool enters_otherwise(const Probe& probe, const enforce::GateReading& gate,
                      std::span<const enforce::GateReading> all);

/// "1ABCDEF0#, 8 bytes from the bus"
std::string to_text(const Probe& probe);

}  // namespace mlcca::readback
