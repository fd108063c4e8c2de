// SPDX-License-Identifier: BSD-2-Clause
// Gives signs of life to the gates, which close without them, and to the service manager.
#pragma once
#include <cstdint>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

class Heartbeat {
 public:
  Heartbeat(GateControl& control, const Clock& clock) : control_(control), clock_(clock) {}

  /// To be called after each step of long work: gives a sign of life if one is due. Gates that have
  /// closed meanwhile stay closed: see GateControl::lapsed().
  void pulse();

  /// Until end_start() each sign of life also keeps in force what a former daemon has left, for at
  /// most `limit` ns. After an error it stays in force only for the grace period.
  Result<void> begin_start(std::uint64_t limit);
  void end_start();

 private:
  GateControl& control_;
  const Clock& clock_;
  bool is_starting_ = false;
  std::uint64_t pulsed_ = 0;  ///< CLOCK_MONOTONIC, ns
};

}  // namespace mlcca
