// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/ether.hpp"

#include <algorithm>
#include <cstddef>

#include "base/big_endian.hpp"

namespace mlcca::learn {
namespace {

constexpr std::uint16_t kIpv4 = 0x0800;
constexpr std::uint16_t kTag = 0x8100;         // 802.1Q
constexpr std::uint16_t kServiceTag = 0x88a8;  // 802.1ad
constexpr unsigned kMostTags = 2;              // the gate skips as many
constexpr std::size_t kAddresses = 12;         // bytes of both MAC addresses
constexpr std::size_t kLeastIp = 20;
constexpr std::size_t kUdp = 8;
constexpr std::uint8_t kUdpProtocol = 17;

std::uint16_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(from_big_endian(bytes.subspan(at, 2)));
}
std::uint32_t address(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(from_big_endian(bytes.subspan(at, 4)));
}

/// Reads a UDP header. `payload` is the size behind the IP header that the header states; `more`
/// says that further IP fragments follow.
Carries read_udp(std::span<const std::uint8_t> udp, std::size_t payload, bool more, Frame& out) {
  if (payload < kUdp || udp.size() < kUdp) return Carries::broken;
  const std::size_t whole = word(udp, 4);
  if (whole < kUdp || (more ? whole <= payload : whole != payload)) return Carries::broken;
  out.datagram->source_port = word(udp, 0);
  out.datagram->port = word(udp, 2);
  out.datagram->bytes = static_cast<std::uint32_t>(whole - kUdp);
  out.data = udp.subspan(kUdp, std::min(udp.size(), payload) - kUdp);
  return Carries::datagram;
}

Carries read_ipv4(std::span<const std::uint8_t> packet, Frame& out) {
  constexpr std::uint16_t offset_bits = 0x1fff;
  constexpr std::uint16_t more_bit = 0x2000;
  if (packet.size() < kLeastIp) return Carries::broken;
  if (packet[9] != kUdpProtocol) return Carries::other;
  const std::size_t header = std::size_t{packet[0] & 0x0fU} * 4;
  const std::size_t total = word(packet, 2);
  if (packet[0] >> 4U != 4 || header < kLeastIp || total <= header || packet.size() < header)
    return Carries::broken;
  const std::uint16_t fragment = word(packet, 6);
  if ((fragment & offset_bits) != 0) return Carries::other;
  out.datagram->source = address(packet, 12);
  out.datagram->destination = address(packet, 16);
  return read_udp(packet.subspan(header), total - header, (fragment & more_bit) != 0, out);
}

}  // namespace

Carries read_ethertype(std::uint16_t ethertype, std::span<const std::uint8_t> packet, Frame& out) {
  if (!out.datagram) out.datagram.emplace();
  for (unsigned tags = 0; ethertype == kTag || ethertype == kServiceTag; ++tags) {
    if (tags == kMostTags) return Carries::other;
    if (packet.size() < 4) return Carries::broken;
    ethertype = word(packet, 2);
    packet = packet.subspan(4);
  }
  return ethertype == kIpv4 ? read_ipv4(packet, out) : Carries::other;
}

Carries read_ethernet(std::span<const std::uint8_t> frame, Frame& out) {
  if (frame.size() < kAddresses + 2) return Carries::broken;
  std::ranges::copy(frame.subspan(6, 6), out.datagram.emplace().mac.begin());
  return read_ethertype(word(frame, kAddresses), frame.subspan(kAddresses + 2), out);
}

}  // namespace mlcca::learn
