// SPDX-License-Identifier: BSD-2-Clause
// What keeps the gates closed when this daemon dies, and other daemons away from them: the pins of
// the control word, and the lock of the bpffs. What another program removes is put back.
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
  /// `root`: the bpffs. All of them must outlive this.
  Safeguards(GateControl& control, EventLog& log, std::string root)
      : control_(control), log_(log), root_(std::move(root)) {}

  /// The lock of lock_gates(): it is kept from now on.
  void keep(Fd lock) { lock_ = std::move(lock); }
  /// Once a second.
  void poll();
  /// What could not be put back, in words.
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
  Problem ungraced_;  ///< why the grace is not as it was set
};

}  // namespace mlcca
