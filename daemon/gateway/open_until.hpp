// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstdint>
#include <optional>

#include "base/clock.hpp"
#include "base/problem.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

/// The time until which the kernel may leave the gates open, as it was set last.
class OpenUntil {
 public:
  OpenUntil(GateControl& control, EventLog& log, const Clock& clock)
      : control_(control), log_(log), clock_(clock) {}

  /// Sets the time: CLOCK_MONOTONIC, ns; 0: no limit. False if the kernel has refused; the next
  /// attempt is a second later, and until then everything that depends on it must stay closed.
  /// `at_once`: a later time takes effect now; otherwise with the next heart-beat.
  [[nodiscard]] bool set(std::uint64_t until, bool at_once);
  [[nodiscard]] bool is_refused() const { return clock_.monotonic_ns() < retry_; }

 private:
  GateControl& control_;
  EventLog& log_;
  const Clock& clock_;
  std::optional<std::uint64_t> until_;  ///< nullopt: it is not known what the kernel has
  std::uint64_t retry_ = 0;             ///< no attempt before this time
  Problem trouble_;
};

}  // namespace mlcca
