// SPDX-License-Identifier: BSD-2-Clause
// Which way a frame goes by an interface.
#pragma once
#include <cstdint>

namespace mlcca::core {

enum class Direction : std::uint8_t { ingress, egress };

inline const char* to_text(Direction direction) {
  return direction == Direction::ingress ? "ingress" : "egress";
}

}  // namespace mlcca::core
