// SPDX-License-Identifier: BSD-2-Clause
// Who carries events from one network to another at a gateway.
#pragma once
#include <cstdint>
#include <optional>

#include "core/model/system.hpp"

namespace mlcca::core {

/// The kernel carries events of the one network to the other at the gateway: can-gw between CAN
/// networks, a bridge or multicast routing between others, where the gateway leaves that to it.
/// Else a program does: sender_at().
[[nodiscard]] inline bool are_joined_by_kernel(const Gateway& gateway, const Network& from,
                                               const Network& to) {
  const bool from_can = from.kind == NetworkKind::can;
  const bool to_can = to.kind == NetworkKind::can;
  return from_can == to_can && (from_can || gateway.forwarder != Forwarder::relay);
}

/// The user whose program sends at the port what the kernel does not carry there; none: nobody may.
[[nodiscard]] inline std::optional<std::uint32_t> sender_at(const Gateway& gateway,
                                                            const Port& port) {
  if (port.sender) return port.sender;
  return gateway.forwarder == Forwarder::relay ? gateway.relay : std::nullopt;
}

}  // namespace mlcca::core
