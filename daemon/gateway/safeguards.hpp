// SPDX-License-Identifier: BSD-2-Clause
// Watches over what keeps the gates closed when this daemon dies and what keeps other daemons away
// from them: the pins of the control word and the lock of the bpffs. Restores what another program
// has removed.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/problem.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

class Safeguards {
 public:
  /// `root` is the path of the bpffs. All references must outlive this object.
  Safeguards(GateControl& control, EventLog& log, std::string root)
      : control_(control), log_(log), root_(std::move(root)) {}

  /// Keeps the lock of lock_gates() from now on.
  void keep(Fd lock) { lock_ = std::move(lock); }
  /// To be called once a second.
  void poll();
  /// What could not be restored, one line each.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  void poll_pins();
  void poll_epoch();
  void poll_grace();
  void poll_lock();

  GateControl& control_;
  EventLog& log_;
  std::string root_;
  Fd lock_;
  Problem unlocked_;
  Problem unpinned_;
  Problem ungraced_;  ///< why the grace period is not the configured one
};

}  // namespace mlcca
