// SPDX-License-Identifier: BSD-2-Clause
// Determines what became of a frame that was sent through a gate.
#pragma once
#include <poll.h>

#include <chrono>
#include <cstdint>
#include <string>

#include "base/handle.hpp"
#include "daemon/gates/counters.hpp"
#include "daemon/gates/port_gate.hpp"

namespace mlcca::readback {

/// The frame arrived, it was counted as dropped, or neither.
enum class Fate : std::uint8_t { passed, dropped, lost };

/// The frames that the gate has dropped in both directions.
inline std::uint64_t drops_of(const gates::PortGate& gate) {
  std::uint64_t sum = 0;
  for (const auto direction : gates::kBothDirections) {
    const auto reasons = gate.reasons(direction);
    for (std::size_t r = 0; r < reasons.size(); ++r)
      if (core::is_drop(gates::reason_of(r))) sum += reasons.at(r);
  }
  return sum;
}

/// Sends the frame and waits for what becomes of it. `to` is readable when something has arrived;
/// `send` returns whether the kernel has taken the frame, `receive` whether the frame has arrived;
/// `drops` is the sum of drops of all gates on the way; none of them waits. What a pair of
/// interfaces delivers waits in a queue that the processor has for all interfaces of the machine
/// (net.core.netdev_max_backlog): other traffic can fill it, and the kernel then loses the frame.
/// So a frame that is lost is sent again, at most twice.
template <class Drops, class Send, class Receive>
Fate fate_of(const Fd& to, const Drops& drops, const Send& send, const Receive& receive,
             std::chrono::milliseconds patience = std::chrono::seconds{5}) {
  constexpr int most_sent = 3;
  for (int sent = 0; sent < most_sent; ++sent) {
    const std::uint64_t before = drops();
    const auto end = std::chrono::steady_clock::now() + patience;
    if (!send() && drops() == before) continue;
    do {
      pollfd wait{.fd = to.get(), .events = POLLIN, .revents = 0};
      const bool dropped = drops() != before;
      // Where poll() fails, nothing waits, and the frame is received all the same.
      static_cast<void>(::poll(&wait, 1, dropped ? 0 : 1));
      if (receive()) return Fate::passed;
      if (dropped) return Fate::dropped;
    } while (std::chrono::steady_clock::now() < end);
  }
  return Fate::lost;
}

}  // namespace mlcca::readback
