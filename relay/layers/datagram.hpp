// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's events in UDP datagrams to port 9999, or as broadcasts to 8888:
//
//   subject[8] flag[1] data     flag 1: the data begins with a fragment header, else it is the
//   event
//
// The group is 239.A.B.C, where A is octet 0 of the subject, B octet 7 and C octet 5 (1 for 0, 254
// for 255). For example "Distance" goes to 239.68.101.110.
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

/// Of a subject, in the order of the host.
[[nodiscard]] std::uint32_t group_of(std::uint64_t subject);

/// A datagram of an event; nothing: it is none.
struct Datagram {
  std::uint64_t subject = 0;
  bool is_fragment = false;
  afp::Octets data;
};
[[nodiscard]] std::optional<Datagram> parse_datagram(afp::Octets octets);
[[nodiscard]] std::array<std::uint8_t, kDatagramHeader> datagram_header(std::uint64_t subject,
                                                                        bool is_fragment);

}  // namespace mlcca::relay
