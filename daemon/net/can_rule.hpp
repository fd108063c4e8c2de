// SPDX-License-Identifier: BSD-2-Clause
// A rule of can-gw, in plain numbers.
#pragma once
#include <compare>
#include <cstdint>

namespace mlcca::net {

/// Frames that are carried from one CAN interface to another.
struct CanRule {
  int from = 0;          ///< ifindex
  int to = 0;            ///< ifindex
  std::uint32_t id = 0;  ///< those with (can_id & mask) == id, as struct can_filter has it
  std::uint32_t mask = 0;
  bool fd = false;           ///< CAN FD frames; else classic ones
  std::uint32_t keep = ~0U;  ///< they leave with the identifier (can_id & keep) | set
  std::uint32_t set = 0;

  auto operator<=>(const CanRule&) const = default;
  [[nodiscard]] bool translates() const { return keep != ~0U || set != 0; }
};

/// Rules of ours carry such a number and no other rule has the same. can-gw takes a number only
/// with a change of the frame: ours change the identifier, perhaps to what it was.
inline constexpr std::uint32_t kFirstUid = 0x4d4c0001;  // "ML"
inline constexpr std::uint32_t kLastUid = 0x4d4cffff;

/// A rule as the kernel has it.
struct CanRuleThere {
  CanRule rule;
  std::uint32_t uid = 0;  ///< 0: none
  std::uint16_t flags = 0;
  bool changes_more = false;  ///< of the frames than CanRule can say
  std::uint8_t hops = 0;      ///< limit of its own, 0: none
  std::uint64_t handled = 0;  ///< frames
  std::uint64_t dropped = 0;
  std::uint64_t deleted = 0;  ///< for too many hops

  [[nodiscard]] bool is_ours() const { return uid >= kFirstUid && uid <= kLastUid; }
  bool operator==(const CanRuleThere&) const = default;
};

}  // namespace mlcca::net
