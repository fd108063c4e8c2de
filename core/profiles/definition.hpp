// SPDX-License-Identifier: BSD-2-Clause
// Helpers for the files that define profiles. All other code uses profile.hpp.
#pragma once
#include <cstdint>

#include "core/profiles/profile.hpp"

namespace mlcca::core::profiles {

// Each profile is defined in the file of its name.
#define PROFILE(word, NAME) extern const ProfileTraits word;
#include "core/profiles/list.inc"

/// Frames with a 29-bit identifier, of which the bits of `open` may have any value.
constexpr ControlFrames extended(std::uint32_t id, std::uint32_t open, std::uint16_t bytes = 8) {
  return {{.id = kExtendedFlag | id, .mask = kExtendedFlag | (kExtendedBits & ~open)}, bytes};
}
/// Frames with an 11-bit identifier, of which the bits of `open` may have any value.
constexpr ControlFrames standard(std::uint32_t id, std::uint32_t open, std::uint16_t bytes) {
  return {{.id = id, .mask = kExtendedFlag | (kExtendedBits & ~open)}, bytes};
}

/// Identifiers are written with all digits that their form has.
inline constexpr NumberText kIdentifierText{.digits = 3, .name_digits = 3};

/// The positions of the priority and of the number in identifiers of J1939 and Cyphal; the source
/// address is below.
inline constexpr unsigned kPriorityShift = 26;
inline constexpr std::uint32_t kPriorityBits = 7U << kPriorityShift;
inline constexpr unsigned kNumberShift = 8;

/// Composes the priority of the binding (open if it states none), its number and the publisher's
/// node.
[[nodiscard]] FrameIdentity with_priority(const Publisher& publisher, const Binding& binding);
/// The identifier of the binding itself with the binding's mask.
[[nodiscard]] FrameIdentity plain(const Publisher& publisher, const Binding& binding,
                                  bool fragmented);

/// What is wrong with an identifier that a description states with form and mask; empty if nothing
/// is.
[[nodiscard]] std::vector<std::string> problems_of_identifier(const Binding& binding);

/// Whether a frame can match both bindings.
[[nodiscard]] bool overlap(const Binding& a, const Binding& b);

}  // namespace mlcca::core::profiles
