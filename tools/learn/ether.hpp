// SPDX-License-Identifier: BSD-2-Clause
// From an Ethernet frame to the UDP datagram in it, as the gate reads it (bpf/ether_parse.bpf.h).
#pragma once
#include <cstdint>
#include <span>

#include "tools/learn/frame.hpp"

namespace mlcca::learn {

enum class Carries : std::uint8_t {
  datagram,  ///< over IPv4, whole or its first IP fragment
  other,     ///< other traffic, or a later IP fragment
  broken,    ///< IPv4 with headers that are wrong or cut off
};

/// Fills `datagram` and `data` of `out`. The frame begins with its addresses, and its end may have
/// been cut off.
Carries read_ethernet(std::span<const std::uint8_t> frame, Frame& out);
/// The same of what is behind an ethertype.
Carries read_ethertype(std::uint16_t ethertype, std::span<const std::uint8_t> packet, Frame& out);

}  // namespace mlcca::learn
