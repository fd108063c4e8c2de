// SPDX-License-Identifier: BSD-2-Clause
// What a plan says of a gate, as a slot of it.
#pragma once
#include <cstdint>

#include "core/gates/plan.hpp"
#include "daemon/gates/slot_spec.hpp"

namespace mlcca::enforce {

/// Of a gate on a network of that kind. `source`: interface of the entry's source port, if it has
/// one.
[[nodiscard]] SlotSpec slot_of(const core::GateEntry& entry, core::NetworkKind kind,
                               std::uint32_t source = 0);
/// With its verdict, its traffic, and how its events are expected.
[[nodiscard]] SlotSpec slot_of(const core::GateRule& rule, core::NetworkKind kind,
                               std::uint32_t source = 0);

}  // namespace mlcca::enforce
