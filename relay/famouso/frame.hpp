// SPDX-License-Identifier: BSD-2-Clause
// A classic CAN frame with a 29-bit identifier as FAMOUSO uses it:
//
//   bits 22 to 28  priority, 0 is the highest; 0x7d without real-time requirements
//   bit  21        the payload begins with a fragment header
//   bits 14 to 20  sending node
//   bits  0 to 13  tag of the subject; below 5: protocols that assign nodes and tags
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace mlcca::relay {

struct Frame {
  std::uint32_t id = 0;
  std::uint8_t length = 0;
  std::array<std::uint8_t, 8> data{};
  friend bool operator==(const Frame&, const Frame&) = default;
};

inline constexpr std::uint32_t kNormalPriority = 0x7dU << 22U;
inline constexpr std::uint32_t kPriorityMask = 0x7fU << 22U;
inline constexpr unsigned kNodeShift = 14;
inline constexpr std::uint32_t kNodeMask = 0x7f;
inline constexpr std::uint32_t kTagMask = 0x3fff;
inline constexpr std::uint32_t kBrokerNode = 0x7f;  ///< sender of the broker's answers

/// Tags of the configuration and binding protocols.
inline constexpr std::uint32_t kNodeAnswer = 0;
inline constexpr std::uint32_t kNodeRequest = 1;
inline constexpr std::uint32_t kTagRequest = 2;
inline constexpr std::uint32_t kTagAnswer = 4;

[[nodiscard]] constexpr std::uint32_t tag_of(const Frame& frame) { return frame.id & kTagMask; }
[[nodiscard]] constexpr std::uint32_t node_of(const Frame& frame) {
  return frame.id >> kNodeShift & kNodeMask;
}
[[nodiscard]] constexpr bool has_normal_priority(const Frame& frame) {
  return (frame.id & kPriorityMask) == kNormalPriority;
}

}  // namespace mlcca::relay
