// SPDX-License-Identifier: BSD-2-Clause
// Slot by slot: what a gate holds, compared with what the daemon wrote into it.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "daemon/gates/readback.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/store/contents.hpp"

namespace mlcca::readback {

/// How an interface is called, by its index.
using NameOf = std::function<std::string(std::uint32_t ifindex)>;

/// A line each: interface, direction, subject, what is and what ought to be.
[[nodiscard]] std::vector<std::string> differences(const enforce::GateReading& gate,
                                                   std::span<const enforce::SlotSpec> ought,
                                                   const NameOf& name_of);

/// Of the gates of all ports in the journal; they become problems of the gate.
void compare_slots(enforce::Reading& reading, const store::Contents& journal);

}  // namespace mlcca::readback
