// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/gates/gate_pins.hpp"

namespace mlcca::enforce {

/// Before the pins of a device that is gone are removed: our programs go on with it where it is
/// now, and let everything pass there.
void retire_gate(const std::string& directory);

/// Before the pins of a gate are given to another one: what is pinned there and is none of these
/// maps, which are attached to the device of this index, belongs to another device, that may have
/// gone to another namespace. No daemon holds it any more: it is closed.
void disown_gate(const std::string& directory, const std::vector<MapIds>& attached);

/// The kernel knows no interface of that index in this network namespace.
bool is_gone(std::uint32_t ifindex);

}  // namespace mlcca::enforce
