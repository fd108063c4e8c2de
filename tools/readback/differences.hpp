// SPDX-License-Identifier: BSD-2-Clause
// Compares the slots of a gate with what the daemon wrote into them, according to the journal.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "daemon/gates/readback.hpp"
#include "daemon/gates/slot_spec.hpp"
#include "daemon/store/contents.hpp"

namespace mlcca::readback {

/// Returns the name of an interface for its index.
using NameOf = std::function<std::string(std::uint32_t ifindex)>;

/// The differences, a line each: interface, direction, subject, present and expected content.
[[nodiscard]] std::vector<std::string> differences(const gates::GateReading& gate,
                                                   std::span<const gates::SlotSpec> ought,
                                                   const NameOf& name_of);

/// Compares the gates of all ports in the journal; differences become problems of the gate.
void compare_slots(gates::Reading& reading, const store::Contents& journal);

}  // namespace mlcca::readback
