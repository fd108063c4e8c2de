// SPDX-License-Identifier: BSD-2-Clause
// A packet socket that is given the UDP datagrams of an Ethernet interface, and nothing else of it.
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

/// Error: the process lacks CAP_NET_RAW, and what else.
Result<Fd> open_packet_socket(const std::string& interface, int index);

/// Of what was read of it, and `type` of sockaddr_ll; false: it is no datagram.
bool read_packet(std::span<const std::uint8_t> bytes, unsigned type, Frame& out);

}  // namespace mlcca::learn
