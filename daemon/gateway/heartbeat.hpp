// SPDX-License-Identifier: BSD-2-Clause
// Signs of life for the gates, which close without them, and for the service manager.
#pragma once
#include <cstdint>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

class Heartbeat {
 public:
  Heartbeat(GateControl& control, const Clock& clock) : control_(control), clock_(clock) {}

  /// To be called after each step of what takes long: gives a sign of life when one is due. Gates
  /// that have closed meanwhile stay closed: see GateControl::lapsed().
  void pulse();

  /// Until end_start() the signs keep in force what a former daemon has left, for `limit` ns. After
  /// an error nothing is kept after the grace.
  Result<void> begin_start(std::uint64_t limit);
  void end_start();

 private:
  GateControl& control_;
  const Clock& clock_;
  bool is_starting_ = false;
  std::uint64_t pulsed_ = 0;  ///< CLOCK_MONOTONIC, ns
};

}  // namespace mlcca
