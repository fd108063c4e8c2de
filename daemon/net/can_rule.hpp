// SPDX-License-Identifier: BSD-2-Clause
// A rule of can-gw, as plain numbers.
#pragma once
#include <compare>
#include <cstdint>

namespace mlcca::net {

/// A rule that carries frames from one CAN interface to another.
struct CanRule {
  int from = 0;          ///< ifindex
  int to = 0;            ///< ifindex
  std::uint32_t id = 0;  ///< frames with (can_id & mask) == id, as in struct can_filter
  std::uint32_t mask = 0;
  bool fd = false;           ///< CAN FD frames; false: classic ones
  std::uint32_t keep = ~0U;  ///< frames leave with the identifier (can_id & keep) | set
  std::uint32_t set = 0;

  auto operator<=>(const CanRule&) const = default;
  [[nodiscard]] bool translates() const { return keep != ~0U || set != 0; }
};

/// Each of our rules has a unique number in this range. can-gw accepts a number only for a rule
/// that changes frames, so our rules change the identifier, if necessary to the same one.
inline constexpr std::uint32_t kFirstUid = 0x4d4c0001;  // "ML"
inline constexpr std::uint32_t kLastUid = 0x4d4cffff;

/// A rule that the kernel has.
struct CanRuleThere {
  CanRule rule;
  std::uint32_t uid = 0;  ///< 0: none
  std::uint16_t flags = 0;
  bool changes_more = false;  ///< changes frames in a way that CanRule cannot express
  std::uint8_t hops = 0;      ///< a separate limit of hops; 0: none
  std::uint64_t handled = 0;  ///< frames carried
  std::uint64_t dropped = 0;
  std::uint64_t deleted = 0;  ///< frames dropped because of too many hops

  [[nodiscard]] bool is_ours() const { return uid >= kFirstUid && uid <= kLastUid; }
  bool operator==(const CanRuleThere&) const = default;
};

}  // namespace mlcca::net
