// SPDX-License-Identifier: BSD-2-Clause
// Finds the UDP datagram in an Ethernet frame, as the gate does (bpf/ether_parse.bpf.h).
#pragma once
#include <cstdint>
#include <span>

#include "tools/learn/frame.hpp"

namespace mlcca::learn {

/// What an Ethernet frame contains.
enum class Carries : std::uint8_t {
  datagram,  ///< a UDP datagram over IPv4, complete or its first IP fragment
  other,     ///< other traffic, or a later IP fragment
  broken,    ///< IPv4 with headers that are wrong or truncated
};

/// Sets `datagram` and `data` of `out`. `frame` begins with the MAC addresses; its end may have
/// been truncated.
Carries read_ethernet(std::span<const std::uint8_t> frame, Frame& out);
/// The same for the packet behind an EtherType.
Carries read_ethertype(std::uint16_t ethertype, std::span<const std::uint8_t> packet, Frame& out);

}  // namespace mlcca::learn
