// SPDX-License-Identifier: BSD-2-Clause
#include "relay/layers/datagram.hpp"

#include <algorithm>

#include "base/big_endian.hpp"

namespace mlcca::relay {
namespace {

constexpr unsigned kOctet = 8;
constexpr std::uint32_t kOctetMask = 0xff;
constexpr std::size_t kSubject = 8;  // octets

std::uint64_t octet_of(std::uint64_t subject, unsigned number) {
  return subject >> kOctet * (kSubject - 1 - number) & kOctetMask;
}

}  // namespace

std::uint32_t group_of(std::uint64_t subject) {
  constexpr std::uint32_t first = 239;
  const auto last = std::clamp<std::uint64_t>(octet_of(subject, 5), 1, 254);
  return static_cast<std::uint32_t>(std::uint64_t{first} << 3 * kOctet |
                                    octet_of(subject, 0) << 2 * kOctet |
                                    octet_of(subject, 7) << kOctet | last);
}

std::optional<Datagram> parse_datagram(afp::Octets octets) {
  if (octets.size() < kDatagramHeader || octets[kSubject] > 1) return std::nullopt;
  Datagram out;
  out.subject = from_big_endian(octets.first(kSubject));
  out.is_fragment = octets[kSubject] == 1;
  out.data = octets.subspan(kDatagramHeader);
  return out;
}

std::array<std::uint8_t, kDatagramHeader> datagram_header(std::uint64_t subject, bool is_fragment) {
  std::array<std::uint8_t, kDatagramHeader> out{};
  std::ranges::copy(big_endian(subject), out.begin());
  out.back() = is_fragment ? 1 : 0;
  return out;
}

}  // namespace mlcca::relay
