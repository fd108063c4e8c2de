// SPDX-License-Identifier: BSD-2-Clause
// Tries a gate of Ethernet or IEEE 802.15.4 on a copy: a pair of virtual Ethernet interfaces.
#pragma once
#include <cstdint>
#include <map>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/ether_gate.hpp"
#include "daemon/gates/readback.hpp"
#include "tools/readback/ether_probes.hpp"
#include "tools/readback/original.hpp"
#include "tools/readback/trial.hpp"

namespace mlcca::readback {

/// The copy of one gate.
class EtherCopy {
 public:
  /// Makes the copy in the present network namespace.
  static Result<EtherCopy> make(const gates::GateReading& gate, const Original& original,
                                const gates::Control& control);

  /// Sends all probes through the copy and records the results; `closed` states that the gate is
  /// closed.
  void run(bool closed, Trial& trial);

 private:
  /// Sockets at both sides of the gate: `near` receives what has passed it, `far` is the wire.
  struct Ends {
    Fd near;
    Fd far;
  };

  EtherCopy(const gates::GateReading& gate, gates::EtherGate copy);
  static Result<Ends> open_ends(int near, int far, std::uint16_t ethertype);
  [[nodiscard]] Result<Fate> fate(const EtherProbe& probe);

  gates::EtherGate gate_;
  int near_index_;
  std::map<std::uint16_t, Ends> ends_;  ///< by EtherType
  EtherProbes probes_;
};

}  // namespace mlcca::readback
