// SPDX-License-Identifier: BSD-2-Clause
// A frame seen on an interface, live or in a recording: a CAN frame, or an Ethernet frame with a
// UDP datagram.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace mlcca::learn {

/// Flags of an identifier, as in linux/can.h.
inline constexpr std::uint32_t kExtended = 0x80000000U;
inline constexpr std::uint32_t kRemote = 0x40000000U;
inline constexpr std::uint32_t kError = 0x20000000U;
inline constexpr std::uint32_t kIdentifierBits = 0x1fffffffU;

/// Time stamps below this, in ns, count from the beginning of a recording and not from 1970.
inline constexpr std::uint64_t kFirstDate = 365ULL * 86'400 * 1'000'000'000;

/// The kind of an interface; unknown while nothing was seen of it.
enum class Medium : std::uint8_t { unknown, can, ethernet };

/// The header fields of a datagram or of its first IP fragment. Addresses are those of IPv4, in
/// host byte order.
struct Datagram {
  std::uint32_t source = 0;
  std::uint32_t destination = 0;
  std::uint16_t source_port = 0;
  std::uint16_t port = 0;   ///< destination port
  std::uint32_t bytes = 0;  ///< size of the data, which may be longer than what was recorded
  std::array<std::uint8_t, 6> mac = {};  ///< of the sender; zeros: not known
};

/// A frame of either kind.
struct Frame {
  std::uint64_t ns = 0;         ///< since 1970 or the beginning of the recording
  std::uint32_t interface = 0;  ///< number of the interface, see Interfaces
  std::uint32_t id = 0;         ///< CAN identifier with the flags above
  bool fd = false;
  bool local = false;                ///< sent by a program of the recording host
  std::optional<Datagram> datagram;  ///< for Ethernet; `id` and `fd` do not apply then
  /// The data of the CAN frame (0 to 64 bytes) or of the datagram; valid only during the call.
  std::span<const std::uint8_t> data;

  [[nodiscard]] bool is_extended() const { return (id & kExtended) != 0; }
};

/// The noun for a count of frames: "frames", or "frame" for 1; on Ethernet "datagrams".
[[nodiscard]] constexpr const char* word_for(std::uint64_t count, Medium medium) {
  if (medium == Medium::ethernet) return count == 1 ? "datagram" : "datagrams";
  return count == 1 ? "frame" : "frames";
}

}  // namespace mlcca::learn
