// SPDX-License-Identifier: BSD-2-Clause
// A copy of an Ethernet gate on a pair of virtual interfaces.
#pragma once
#include <memory>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/readback.hpp"
#include "tools/readback/ether_probes.hpp"
#include "tools/readback/original.hpp"
#include "tools/readback/trial.hpp"

namespace mlcca::readback {

class EtherCopy {
 public:
  /// In this network namespace.
  static Result<EtherCopy> make(const enforce::GateReading& gate, const Original& original,
                                const enforce::Control& control);

  void run(bool closed, Trial& trial) const;

 private:
  /// What has passed the gate from the wire, and the wire.
  struct Ends {
    Fd near;
    Fd far;
  };

  EtherCopy(const enforce::GateReading& gate, enforce::EtherGate copy, Ends ip, Ends awds);
  static Result<Ends> open_ends(int near, int far, std::uint16_t ethertype);
  [[nodiscard]] Result<Fate> fate(const EtherProbe& probe) const;

  enforce::EtherGate gate_;
  int near_index_;
  Ends ip_;
  Ends awds_;
  EtherProbes probes_;
};

}  // namespace mlcca::readback
