// SPDX-License-Identifier: BSD-2-Clause
// Tries CAN gates on copies: pairs of virtual CAN interfaces with the gate programs and can-gw
// rules between them.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/gate.hpp"
#include "daemon/gates/readback.hpp"
#include "daemon/net/can_routes.hpp"
#include "tools/readback/original.hpp"
#include "tools/readback/probes.hpp"
#include "tools/readback/trial.hpp"

namespace mlcca::readback {

/// The copies of all CAN gates of a reading.
class CanCopies {
 public:
  CanCopies(const gates::Reading& reading, const gates::Control& control)
      : reading_(&reading), control_(&control) {}

  /// Makes the copy of `gate`, a gate of the reading, in the present network namespace.
  Result<void> add(const gates::GateReading& gate, const Original& original);
  /// Sends all probe frames through the copy of a gate and records the results; `closed` states
  /// that the gates are closed.
  void run(std::uint32_t ifindex, bool closed, Trial& trial);

 private:
  struct Copy {
    const gates::GateReading* original;
    gates::Gate gate;
    Fd near;  ///< the end of programs on this machine
    Fd far;   ///< the end of the bus
  };
  [[nodiscard]] const Copy* find(std::uint32_t ifindex) const;
  void run_through(std::uint32_t source, const std::vector<Probe>& frames, const Copy& copy,
                   bool closed, Trial& trial);
  [[nodiscard]] Result<void> forward(std::uint32_t from, std::uint32_t to, bool wanted);
  [[nodiscard]] Result<Fate> fate(const Probe& probe, const Copy& copy) const;
  void try_one(const Probe& probe, const Copy& copy, bool closed, Trial& trial) const;

  const gates::Reading* reading_;
  const gates::Control* control_;
  net::KernelCanRules rules_;
  std::vector<std::unique_ptr<Copy>> copies_;
};

}  // namespace mlcca::readback
