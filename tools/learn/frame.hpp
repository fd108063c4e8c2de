// SPDX-License-Identifier: BSD-2-Clause
// A CAN frame as it was seen on an interface, live or in a recording.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace mlcca::learn {

/// Flags of an identifier, as the kernel has them (linux/can.h).
inline constexpr std::uint32_t kExtended = 0x80000000U;
inline constexpr std::uint32_t kRemote = 0x40000000U;
inline constexpr std::uint32_t kError = 0x20000000U;
inline constexpr std::uint32_t kIdentifierBits = 0x1fffffffU;

struct Frame {
  std::uint64_t ns = 0;         ///< since 1970, or since the recording began
  std::uint32_t interface = 0;  ///< number of its name, see Interfaces
  std::uint32_t id = 0;         ///< with the flags above
  bool fd = false;
  bool local = false;                  ///< sent by a program of the host that recorded it
  std::span<const std::uint8_t> data;  ///< 0 to 64 bytes, valid during the call that hands it over

  [[nodiscard]] bool is_extended() const { return (id & kExtended) != 0; }
};

}  // namespace mlcca::learn
