// SPDX-License-Identifier: BSD-2-Clause
// The programs that a gate has pinned. They are read before the process enters a mount namespace in
// which the pins are not visible.
#pragma once
#include <array>
#include <string>

#include "base/handle.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::readback {

/// The identity of the programs of a gate.
struct Original {
  std::array<std::string, 2> tags;  ///< tags of the ingress and the egress program: hashes of their
                                    ///< instructions, by the kernel

  explicit Original(const std::string& directory)
      : tags{tag(directory, gates::Direction::ingress), tag(directory, gates::Direction::egress)} {}

 private:
  static std::string tag(const std::string& directory, gates::Direction direction) {
    const Fd program = gates::open_pin(gates::program_pin(directory, direction));
    return program ? gates::program_info(program.get()).tag : std::string();
  }
};

/// The first interface index for the far ends of pairs: no gateway reaches it.
inline constexpr int kFarIndex = 1'000'000'000;

/// The problem if the copy runs other instructions than the original.
inline constexpr const char* kOtherVersion =
    "its programs are those of another version than this one: restart mlccad";

}  // namespace mlcca::readback
