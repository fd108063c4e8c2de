// SPDX-License-Identifier: BSD-2-Clause
// What entries keep encoded: the grants of a channel, and the slots that its gates were
// to hold.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/admission/state.hpp"
#include "daemon/gates/slot_spec.hpp"

namespace mlcca::store {

/// A Grants message; empty: nothing is granted.
[[nodiscard]] std::string record_of(const core::Grants& grants);
/// Nothing for bytes that are none of ours.
[[nodiscard]] std::optional<core::Grants> grants_in(std::string_view record);

/// A Slots message, in which the subject is not; empty: no slots.
[[nodiscard]] std::string record_of(std::span<const enforce::PlacedSlot> slots);
/// Nothing for bytes that are none of ours.
[[nodiscard]] std::optional<std::vector<enforce::PlacedSlot>> slots_in(std::string_view record,
                                                                       std::uint64_t subject);

}  // namespace mlcca::store
