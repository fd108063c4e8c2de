// SPDX-License-Identifier: BSD-2-Clause
// Who carries events from one network to another at a gateway.
#pragma once
#include "core/model/system.hpp"

namespace mlcca::core {

/// The kernel forwards events between CAN networks, and between other networks; from one to the
/// other a program does (Port::sender).
[[nodiscard]] inline bool are_joined_by_kernel(const Network& a, const Network& b) {
  return (a.kind == NetworkKind::can) == (b.kind == NetworkKind::can);
}

}  // namespace mlcca::core
