// SPDX-License-Identifier: BSD-2-Clause
// Turns a rule of a plan into a slot of a gate.
#pragma once
#include <cstdint>

#include "core/gates/plan.hpp"
#include "daemon/gates/slot_spec.hpp"

namespace mlcca::gates {

/// The slot of an entry for a gate on a network of that kind, without verdict and traffic. `source`
/// is the interface index of the entry's source port, if it has one.
[[nodiscard]] SlotSpec slot_of(const core::GateEntry& entry, core::NetworkKind kind,
                               std::uint32_t source = 0);
/// The slot of a rule, with its verdict, its traffic, and how its events are expected.
[[nodiscard]] SlotSpec slot_of(const core::GateRule& rule, core::NetworkKind kind,
                               std::uint32_t source = 0);

}  // namespace mlcca::gates
