// SPDX-License-Identifier: BSD-2-Clause
// Who sends on a network whose frames carry the subject, as they show it.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::core {

enum class NetworkKind : std::uint8_t;

/// An IPv4 address (datagrams) or a MAC address (events in AWDS packets); on 802.15.4 an extended
/// address, or a PAN and a short address; 0: the wildcard.
struct Station {
  /// As in bpf/ether.h. IPv4: below 2^32. MAC: 2^48 and its 48 bits. Short: 2^49, PAN and address.
  /// Extended: its 64 bits, and in them 2^56, which is the bit of a group.
  std::uint64_t bits = 0;

  [[nodiscard]] bool is_wildcard() const { return bits == 0; }
  /// Of 802.15.4.
  [[nodiscard]] bool is_wpan() const { return bits >> 49U != 0; }
  auto operator<=>(const Station&) const = default;
};

/// "192.0.2.7" or "02:00:00:00:00:01"; of 802.15.4 "02:00:00:00:00:00:00:01", or PAN and short
/// address "0xbeef:0x0001"; in either case. Nothing for anything else, and for addresses that no
/// station sends from: 0.0.0.0, those of groups, 255.255.255.255, 00:00:00:00:00:00, short ones
/// from 0xfffe on.
[[nodiscard]] std::optional<Station> station_of(std::string_view text);
/// The same of a network of that kind alone.
[[nodiscard]] std::optional<Station> station_on(NetworkKind kind, std::string_view text);
/// What to state there, with an example.
[[nodiscard]] std::string_view station_words(NetworkKind kind);
/// As station_of() reads it; "" for the wildcard.
[[nodiscard]] std::string to_text(Station station);

}  // namespace mlcca::core
