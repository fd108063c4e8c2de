// SPDX-License-Identifier: BSD-2-Clause
// What has become of something that was sent through a gate.
#pragma once
#include <poll.h>

#include <chrono>
#include <cstdint>
#include <string>

#include "base/handle.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/port_gate.hpp"

namespace mlcca::readback {

/// It has come where it should go, has been counted as dropped, or neither.
enum class Fate : std::uint8_t { passed, dropped, lost };

inline std::uint64_t drops_of(const enforce::PortGate& gate) {
  std::uint64_t sum = 0;
  for (const auto direction : enforce::kBothDirections) {
    const auto reasons = gate.reasons(direction);
    for (std::size_t r = 0; r < reasons.size(); ++r)
      if (enforce::is_drop(static_cast<gate_reason>(r))) sum += reasons.at(r);
  }
  return sum;
}

/// `to` is readable when it has come; `receive` returns whether that was it; `drops` counts what
/// the gates on the way have dropped.
template <class Drops, class Send, class Receive>
Fate fate_of(const Fd& to, const Drops& drops, const Send& send, const Receive& receive) {
  constexpr std::chrono::seconds patience{5};  // where others use the processors, too
  const std::uint64_t before = drops();
  const auto end = std::chrono::steady_clock::now() + patience;
  send();
  do {
    pollfd wait{.fd = to.get(), .events = POLLIN, .revents = 0};
    const bool dropped = drops() != before;
    if (::poll(&wait, 1, dropped ? 0 : 1) == 1 && receive()) return Fate::passed;
    if (dropped) return Fate::dropped;
  } while (std::chrono::steady_clock::now() < end);
  return Fate::lost;
}

}  // namespace mlcca::readback
