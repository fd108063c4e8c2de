// SPDX-License-Identifier: BSD-2-Clause
// A packet socket that receives only the UDP datagrams of an Ethernet interface.
#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "tools/learn/frame.hpp"

namespace mlcca::learn {

/// Bytes of a frame that are read: headers with options and tags, and the beginning of an event.
inline constexpr std::size_t kFrameRead = 256;

/// Opens the socket, which receives nothing yet. The error names CAP_NET_RAW if the process lacks
/// it.
Result<Fd> open_packet_socket(const std::string& interface);
/// Makes the socket receive from the interface of that index.
Result<void> bind_packet_socket(const Fd& socket, const std::string& interface, int index);

/// Decodes received bytes; `type` is sll_pkttype of sockaddr_ll. False: they contain no datagram.
bool read_packet(std::span<const std::uint8_t> bytes, unsigned type, Frame& out);

}  // namespace mlcca::learn
