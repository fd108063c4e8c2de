// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/heartbeat.hpp"

#include "base/at_once.hpp"

namespace mlcca {

void Heartbeat::pulse() {
  const std::uint64_t now = clock_.monotonic_ns();
  if (now - pulsed_ < control_.beat_interval() / 4) return;
  pulsed_ = now;
  if (is_starting_) {
    control_.beat_while_starting(now);
    notify("EXTEND_TIMEOUT_USEC=30000000");
    return;
  }
  if (!control_.lapsed()) static_cast<void>(control_.beat(now));
  notify("WATCHDOG=1");
}

Result<void> Heartbeat::begin_start(std::uint64_t limit) {
  is_starting_ = true;
  return control_.begin_start(limit, clock_.monotonic_ns());
}

void Heartbeat::end_start() {
  control_.end_start();
  is_starting_ = false;
}

}  // namespace mlcca
