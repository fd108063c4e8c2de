// SPDX-License-Identifier: BSD-2-Clause
// Who sends on an Ethernet-like network, as its frames show it.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::core {

/// An IPv4 address (datagrams) or a MAC address (events in AWDS packets); 0: the wildcard.
struct Station {
  std::uint64_t bits = 0;  ///< as in bpf/ether.h: IPv4 below 2^32; MAC: 2^48 and its 48 bits

  [[nodiscard]] bool is_wildcard() const { return bits == 0; }
  auto operator<=>(const Station&) const = default;
};

/// "192.0.2.7" or "02:00:00:00:00:01", in either case. Nothing for anything else, and for addresses
/// that no station sends from: 0.0.0.0, those of groups, 255.255.255.255, 00:00:00:00:00:00.
[[nodiscard]] std::optional<Station> station_of(std::string_view text);

/// As station_of() reads it; "" for the wildcard.
[[nodiscard]] std::string to_text(Station station);

}  // namespace mlcca::core
