// SPDX-License-Identifier: BSD-2-Clause
// A frame as it was seen on an interface, live or in a recording: of CAN, or of Ethernet with a UDP
// datagram in it.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace mlcca::learn {

/// Flags of an identifier, as the kernel has them (linux/can.h).
inline constexpr std::uint32_t kExtended = 0x80000000U;
inline constexpr std::uint32_t kRemote = 0x40000000U;
inline constexpr std::uint32_t kError = 0x20000000U;
inline constexpr std::uint32_t kIdentifierBits = 0x1fffffffU;

/// Time stamps before this one count from the beginning of a recording, and not from 1970, ns.
inline constexpr std::uint64_t kFirstDate = 365ULL * 86'400 * 1'000'000'000;

/// What an interface has; unknown: nothing was seen of it yet.
enum class Medium : std::uint8_t { unknown, can, ethernet };

/// What the headers of a datagram say, or of its first IP fragment. Addresses are those of IPv4, in
/// the order of the host.
struct Datagram {
  std::uint32_t source = 0;
  std::uint32_t destination = 0;
  std::uint16_t source_port = 0;
  std::uint16_t port = 0;                ///< where it goes
  std::uint32_t bytes = 0;               ///< of its data, of which the end may not be there
  std::array<std::uint8_t, 6> mac = {};  ///< of the sender; zeros: not known
};

struct Frame {
  std::uint64_t ns = 0;         ///< since 1970, or since the recording began
  std::uint32_t interface = 0;  ///< number of its name, see Interfaces
  std::uint32_t id = 0;         ///< with the flags above
  bool fd = false;
  bool local = false;                ///< sent by a program of the host that recorded it
  std::optional<Datagram> datagram;  ///< of an Ethernet frame, which has neither `id` nor `fd`
  /// Of CAN 0 to 64 bytes, of a datagram its data; valid during the call that hands it over.
  std::span<const std::uint8_t> data;

  [[nodiscard]] bool is_extended() const { return (id & kExtended) != 0; }
};

/// What is counted, without its number: "frames", or "frame" of one.
[[nodiscard]] constexpr const char* word_for(std::uint64_t count, Medium medium) {
  if (medium == Medium::ethernet) return count == 1 ? "datagram" : "datagrams";
  return count == 1 ? "frame" : "frames";
}

}  // namespace mlcca::learn
