// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/gates/gate_pins.hpp"

namespace mlcca::gates {

/// To be called before the pins of a device that is gone are removed. Our programs stay with the
/// device and let everything pass where it is now.
void retire_gate(const std::string& directory);

/// To be called before the pins of a gate are given to another gate. Pinned maps that are not among
/// `attached` (the maps at the device of this index) belong to another device, perhaps in another
/// network namespace. No daemon holds that gate any more, so it is closed.
void disown_gate(const std::string& directory, const std::vector<MapIds>& attached);

/// Whether the kernel knows no interface of that index in this network namespace.
bool is_gone(std::uint32_t ifindex);

}  // namespace mlcca::gates
