// SPDX-License-Identifier: BSD-2-Clause
// What the gates were told to hold of a subject, as the octets that the journal keeps.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/gates/slot_spec.hpp"

namespace mlcca::enforce {

/// A slot, and the interface that has it.
struct PlacedSlot {
  std::uint32_t ifindex = 0;
  SlotSpec slot;
  bool operator==(const PlacedSlot&) const = default;
};

/// The subject is not in there. Of no slots: empty.
[[nodiscard]] std::string record_of(std::span<const PlacedSlot> slots);
/// Nothing for octets that are none of ours.
[[nodiscard]] std::optional<std::vector<PlacedSlot>> slots_in(std::string_view record,
                                                              std::uint64_t subject);

}  // namespace mlcca::enforce
