// SPDX-License-Identifier: BSD-2-Clause
// The direction of a frame at an interface, as the traffic control of Linux names it.
#pragma once
#include <cstdint>

namespace mlcca::core {

enum class Direction : std::uint8_t { ingress, egress };

inline const char* to_text(Direction direction) {
  return direction == Direction::ingress ? "ingress" : "egress";
}

}  // namespace mlcca::core
