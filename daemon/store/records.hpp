// SPDX-License-Identifier: BSD-2-Clause
// Encodes what journal entries contain as bytes: the grants of a channel, and the slots that its
// gates were to hold.
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

/// An encoded Grants message; empty if nothing is granted.
[[nodiscard]] std::string record_of(const core::Grants& grants);
/// nullopt if the bytes are no such message.
[[nodiscard]] std::optional<core::Grants> grants_in(std::string_view record);

/// An encoded Slots message, without the subject; empty if there are no slots.
[[nodiscard]] std::string record_of(std::span<const gates::PlacedSlot> slots);
/// nullopt if the bytes are no such message.
[[nodiscard]] std::optional<std::vector<gates::PlacedSlot>> slots_in(std::string_view record,
                                                                     std::uint64_t subject);

}  // namespace mlcca::store
