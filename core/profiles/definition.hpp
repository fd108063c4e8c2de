// SPDX-License-Identifier: BSD-2-Clause
// What the files of the profiles are made of. Everybody else asks profile.hpp.
#pragma once
#include <cstdint>

#include "core/profiles/profile.hpp"

namespace mlcca::core::profiles {

// Each is defined in the file of its name.
#define PROFILE(word, NAME) extern const ProfileTraits word;
#include "core/profiles/list.inc"

/// Of 29 bits; those of `open` may be any.
constexpr ControlFrames extended(std::uint32_t id, std::uint32_t open, std::uint16_t bytes = 8) {
  return {{.id = kExtendedFlag | id, .mask = kExtendedFlag | (kExtendedBits & ~open)}, bytes};
}
/// Of 11 bits.
constexpr ControlFrames standard(std::uint32_t id, std::uint32_t open, std::uint16_t bytes) {
  return {{.id = id, .mask = kExtendedFlag | (kExtendedBits & ~open)}, bytes};
}

/// Where J1939 and Cyphal have the priority, and their number above the source address.
inline constexpr unsigned kPriorityShift = 26;
inline constexpr std::uint32_t kPriorityBits = 7U << kPriorityShift;
inline constexpr unsigned kNumberShift = 8;

/// Priority as the binding has it, number and source.
[[nodiscard]] FrameIdentity with_priority(const Publisher& publisher, const Binding& binding);
/// The identifier itself, with the bits that the binding's mask has.
[[nodiscard]] FrameIdentity plain(const Publisher& publisher, const Binding& binding,
                                  bool fragmented);

/// What is wrong with an identifier that a description states in a form and with a mask.
[[nodiscard]] std::vector<std::string> problems_of_identifier(const Binding& binding);

/// Some frame has both identifiers.
[[nodiscard]] bool overlap(const Binding& a, const Binding& b);

}  // namespace mlcca::core::profiles
