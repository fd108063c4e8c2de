// SPDX-License-Identifier: BSD-2-Clause
// Decides who carries events from one network to another at a gateway: the kernel or a program.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Whether the kernel carries events between the two networks at this gateway: can-gw between CAN
/// networks; a bridge or multicast routing between Ethernet-like ones, unless the gateway uses the
/// relay. If it returns false, the program of sender_at() carries them.
[[nodiscard]] inline bool are_joined_by_kernel(const Gateway& gateway, const Network& from,
                                               const Network& to) {
  const bool from_can = from.kind == NetworkKind::can;
  const bool to_can = to.kind == NetworkKind::can;
  if (from.kind == NetworkKind::ieee802154 || to.kind == NetworkKind::ieee802154) return false;
  return from_can == to_can && (from_can || gateway.forwarder != Forwarder::relay);
}

/// Whether the kernel forwards frames from a CAN bus to `hops[hop]`, so that they arrive as they
/// left that bus. `hops` is the route as hops_of() gives it.
[[nodiscard]] inline bool is_forwarded(const System& system, std::span<const Place> hops,
                                       std::size_t hop) {
  if (hop < 2 || hops[hop].kind != Place::Kind::network ||
      hops[hop - 1].kind != Place::Kind::gateway || hops[hop - 2].kind != Place::Kind::network)
    return false;
  const Network& from = system.networks[hops[hop - 2].index];
  return from.kind == NetworkKind::can &&
         are_joined_by_kernel(system.gateways[hops[hop - 1].index], from,
                              system.networks[hops[hop].index]);
}

/// The user ID of the program that may send on this port what the kernel does not carry there;
/// nullopt: no program may.
[[nodiscard]] inline std::optional<std::uint32_t> sender_at(const Gateway& gateway,
                                                            const Port& port) {
  if (port.sender) return port.sender;
  return gateway.forwarder == Forwarder::relay ? gateway.relay : std::nullopt;
}

}  // namespace mlcca::core
