// SPDX-License-Identifier: BSD-2-Clause
// Reads what the gate of one Ethernet-like interface has counted, as counters.hpp does.
#pragma once
#include <span>
#include <vector>

#include "bpf/ether.h"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/ether_table.hpp"

namespace mlcca::enforce {

SlotCounters ether_counters(const EtherMemory& memory, std::uint32_t slot);
ReasonCounters ether_reasons(std::span<const ether_cpu> cpus, Direction direction);
/// Datagrams without a slot, newest first.
std::vector<UnknownFrame> unknown_subjects(std::span<const ether_cpu> cpus);

}  // namespace mlcca::enforce
