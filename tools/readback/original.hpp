// SPDX-License-Identifier: BSD-2-Clause
// Which programs a gate has pinned, read before its pins are out of sight.
#pragma once
#include <array>
#include <string>

#include "base/handle.hpp"
#include "daemon/gates/gate_pins.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::readback {

struct Original {
  std::array<std::string, 2> tags;  ///< of the instructions of its programs

  explicit Original(const std::string& directory)
      : tags{tag(directory, enforce::Direction::ingress),
             tag(directory, enforce::Direction::egress)} {}

 private:
  static std::string tag(const std::string& directory, enforce::Direction direction) {
    const Fd program = enforce::open_pin(enforce::program_pin(directory, direction));
    return program ? enforce::program_info(program.get()).tag : std::string();
  }
};

/// Far ends of pairs have indices that no gateway reaches.
inline constexpr int kFarIndex = 1'000'000'000;

/// The copy judges by other instructions than the original.
inline constexpr const char* kOtherVersion =
    "its programs are those of another version than this one: restart mlccad";

}  // namespace mlcca::readback
