// SPDX-License-Identifier: BSD-2-Clause
// Who carries events from one network to another at a gateway.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "core/model/system.hpp"

namespace mlcca::core {

/// The kernel carries events of the one network to the other at the gateway: can-gw between CAN
/// networks, a bridge or multicast routing between Ethernet-like ones, where the gateway leaves
/// that to it. Else a program does: sender_at().
[[nodiscard]] inline bool are_joined_by_kernel(const Gateway& gateway, const Network& from,
                                               const Network& to) {
  const bool from_can = from.kind == NetworkKind::can;
  const bool to_can = to.kind == NetworkKind::can;
  if (from.kind == NetworkKind::ieee802154 || to.kind == NetworkKind::ieee802154) return false;
  return from_can == to_can && (from_can || gateway.forwarder != Forwarder::relay);
}

/// Frames come to the hop of a way as they leave the bus before: the kernel carries them.
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

/// The user whose program sends at the port what the kernel does not carry there; none: nobody may.
[[nodiscard]] inline std::optional<std::uint32_t> sender_at(const Gateway& gateway,
                                                            const Port& port) {
  if (port.sender) return port.sender;
  return gateway.forwarder == Forwarder::relay ? gateway.relay : std::nullopt;
}

}  // namespace mlcca::core
