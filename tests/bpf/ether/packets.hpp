// SPDX-License-Identifier: BSD-2-Clause
// Ethernet frames as octets: what FAMOUSO and AWDS put on a wire, and what no sender should.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

namespace mlcca::test {

using Bytes = std::vector<std::uint8_t>;

/// An event in a UDP datagram, or any other one; what is not stated is as it should be.
struct Datagram {
  std::uint64_t subject = 0;
  std::uint8_t flag = 0;    ///< behind the subject
  std::size_t payload = 8;  ///< octets of the event
  std::uint16_t port = 9999;
  std::uint32_t source = 0x0a000001;
  std::uint32_t destination = 0xef446e65;
  std::uint16_t id = 1;
  std::uint8_t options = 0;  ///< octets of IPv4 options, a multiple of 4 up to 40
  std::uint8_t protocol = 17;
  std::uint8_t version = 4;
  std::optional<std::uint8_t> ihl = {};  ///< in words
  int longer_udp = 0;                    ///< what the UDP length says more than there is
  int longer_ip = 0;

  /// The octets behind the IP header.
  [[nodiscard]] Bytes content() const;
  [[nodiscard]] Bytes whole() const;  ///< in an IP packet
  /// Octets `from` to `to` of the content, in an IP packet.
  [[nodiscard]] Bytes fragment(std::size_t from, std::size_t to) const;

 private:
  [[nodiscard]] Bytes ip(const Bytes& content, std::uint16_t fragment) const;
};

/// In an Ethernet frame with tags of these types.
Bytes ethernet(std::uint16_t type, const Bytes& payload,
               const std::vector<std::uint16_t>& tags = {});
inline Bytes frame(const Bytes& ip) { return ethernet(0x0800, ip); }

/// The MAC address that the sender of an AWDS packet has in it.
inline constexpr std::uint64_t kAwdsSource = 0x02a1b2c3d4e5;
/// AWDS packets as they follow the Ethernet header.
Bytes awds_flood(std::uint8_t kind, const Bytes& payload);
Bytes awds_unicast(std::uint8_t kind, const Bytes& payload);
/// A packet of batman-adv, as it follows the Ethernet header: `type` is one of batadv_packettype,
/// of which BCAST, UNICAST and UNICAST_4ADDR carry the Ethernet frame `payload`.
Bytes batman(std::uint8_t type, const Bytes& payload, std::uint8_t version = 15);
/// What follows the kind of a packet that publishes.
Bytes awds_event(std::uint64_t subject, std::size_t payload, int longer = 0);

}  // namespace mlcca::test
