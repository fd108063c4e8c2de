// SPDX-License-Identifier: BSD-2-Clause
// The datagrams that carry FAMOUSO's events on UDP, to port 9999, or as broadcasts to port 8888:
//
//   subject[8] flag[1] data     flag 1: the data begins with a fragment header;
//                               otherwise it is the event
//
// The multicast group is 239.A.B.C, where A is octet 0 of the subject, B octet 7 and C octet 5 (0
// is replaced by 1, and 255 by 254). For example, "Distance" is sent to 239.68.101.110.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "relay/afp.hpp"

namespace mlcca::relay {

inline constexpr std::uint16_t kEventPort = 9999;
inline constexpr std::uint16_t kBroadcastPort = 8888;
inline constexpr std::size_t kDatagramHeader = 9;

/// The multicast group of a subject, in host byte order.
[[nodiscard]] std::uint32_t group_of(std::uint64_t subject);

/// A parsed datagram. parse_datagram() returns nullopt if the octets are none.
struct Datagram {
  std::uint64_t subject = 0;
  bool is_fragment = false;
  afp::Octets data;
};
[[nodiscard]] std::optional<Datagram> parse_datagram(afp::Octets octets);
[[nodiscard]] std::array<std::uint8_t, kDatagramHeader> datagram_header(std::uint64_t subject,
                                                                        bool is_fragment);

}  // namespace mlcca::relay
