// SPDX-License-Identifier: BSD-2-Clause
// The address of a sender on a network whose frames carry the subject, in the form in which gates
// see it.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::core {

enum class NetworkKind : std::uint8_t;

/// A source address: IPv4 (datagrams), MAC (events in AWDS packets), or on 802.15.4 an extended
/// address or a PAN with a short address. 0 is the wildcard for any sender.
struct Station {
  /// Encoded as in bpf/ether.h. IPv4: the address, below 2^32. MAC: bit 48 and its 48 bits. Short:
  /// bit 49, PAN and address. Extended: its 64 bits with bit 56 set; that is the group bit, which
  /// is clear in every address of a single node.
  std::uint64_t bits = 0;

  [[nodiscard]] bool is_wildcard() const { return bits == 0; }
  /// Whether it is an address of 802.15.4.
  [[nodiscard]] bool is_wpan() const { return bits >> 49U != 0; }
  auto operator<=>(const Station&) const = default;
};

/// Parses "192.0.2.7" or "02:00:00:00:00:01"; for 802.15.4 "02:00:00:00:00:00:00:01" or PAN and
/// short address "0xbeef:0x0001". Digits may be of either case. Returns nullopt for anything else
/// and for addresses that are never a source: 0.0.0.0, 255.255.255.255, 00:00:00:00:00:00, loopback
/// and group addresses, and short addresses from 0xfffe on.
[[nodiscard]] std::optional<Station> station_of(std::string_view text);
/// Parses only the forms that a network of this kind uses.
[[nodiscard]] std::optional<Station> station_on(NetworkKind kind, std::string_view text);
/// Describes the form of an address on such a network, with an example, for messages about errors.
[[nodiscard]] std::string_view station_words(NetworkKind kind);
/// Formats an address as station_of() reads it; "" for the wildcard.
[[nodiscard]] std::string to_text(Station station);

}  // namespace mlcca::core
