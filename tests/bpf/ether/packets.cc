// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bpf/ether/packets.hpp"

#include <linux/batadv_packet.h>

#include "bpf/ether.h"

namespace mlcca::test {
namespace {

void put(Bytes& to, std::uint64_t number, int octets) {
  while (octets-- > 0) to.push_back(static_cast<std::uint8_t>(number >> (8 * octets)));
}

void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

Bytes awds(std::uint8_t type, std::size_t kind_at, std::uint8_t kind, const Bytes& payload) {
  Bytes out(kind_at, 0x22);
  out[0] = type;
  for (std::size_t i = 0; i < 6; ++i)
    out[ETHER_AWDS_SOURCE + i] = static_cast<std::uint8_t>(kAwdsSource >> (8 * (5 - i)));
  out.push_back(kind);
  append(out, payload);
  return out;
}

}  // namespace

Bytes Datagram::content() const {
  Bytes out;
  const std::size_t size = 8 + 9 + payload;
  put(out, 50000, 2);
  put(out, port, 2);
  put(out, static_cast<std::uint64_t>(static_cast<int>(size) + longer_udp), 2);
  put(out, 0, 2);
  put(out, subject, 8);
  put(out, flag, 1);
  for (std::size_t i = 0; i < payload; ++i) out.push_back(static_cast<std::uint8_t>(i));
  return out;
}

Bytes Datagram::ip(const Bytes& content, std::uint16_t fragment) const {
  Bytes out;
  const int words = 5 + options / 4;
  const int header = 4 * words;
  put(out,
      static_cast<std::uint64_t>(version << 4 | ihl.value_or(static_cast<std::uint8_t>(words))), 1);
  put(out, 0, 1);
  put(out, static_cast<std::uint64_t>(header + static_cast<int>(content.size()) + longer_ip), 2);
  put(out, id, 2);
  put(out, fragment, 2);
  put(out, 1, 1);
  put(out, protocol, 1);
  put(out, 0, 2);
  put(out, source, 4);
  put(out, destination, 4);
  for (int i = 0; i < options; ++i) put(out, 1, 1);  // no operation
  append(out, content);
  return out;
}

Bytes Datagram::whole() const { return ip(content(), 0x4000); }

Bytes Datagram::fragment(std::size_t from, std::size_t to) const {
  const Bytes all = content();
  const bool more = to < all.size();
  return ip({all.begin() + static_cast<std::ptrdiff_t>(from),
             all.begin() + static_cast<std::ptrdiff_t>(to)},
            static_cast<std::uint16_t>((more ? 0x2000U : 0U) | from / 8));
}

Bytes ethernet(std::uint16_t type, const Bytes& payload, const std::vector<std::uint16_t>& tags) {
  Bytes out{0x01, 0, 0x5e, 0x44, 0x6e, 0x65, 0x02, 0, 0, 0, 0, 0x01};
  for (const std::uint16_t tag : tags) {
    put(out, tag, 2);
    put(out, 5, 2);
  }
  put(out, type, 2);
  append(out, payload);
  return out;
}

Bytes awds_flood(std::uint8_t kind, const Bytes& payload) { return awds(1, 16, kind, payload); }
Bytes awds_unicast(std::uint8_t kind, const Bytes& payload) { return awds(2, 22, kind, payload); }

Bytes batman(std::uint8_t type, const Bytes& payload, std::uint8_t version) {
  std::size_t header = sizeof(batadv_unicast_packet);
  if (type == BATADV_BCAST) header = sizeof(batadv_bcast_packet);
  if (type == BATADV_UNICAST_4ADDR) header = sizeof(batadv_unicast_4addr_packet);
  if (type == BATADV_UNICAST_FRAG) header = sizeof(batadv_frag_packet);
  Bytes out(header, 0x33);
  out[0] = type;
  out[1] = version;
  append(out, payload);
  return out;
}

Bytes awds_event(std::uint64_t subject, std::size_t payload, int longer) {
  Bytes out{0xaa};
  put(out, static_cast<std::uint64_t>(static_cast<int>(8 + payload) + longer), 2);
  put(out, subject, 8);
  out.resize(out.size() + payload);
  return out;
}

}  // namespace mlcca::test
