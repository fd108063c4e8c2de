// SPDX-License-Identifier: BSD-2-Clause
// The programs that close an interface before there is a daemon. They have no tables and pass only
// what a closed gate passes. The kernel verifies them in 1 to 2 ms, a gate in 13 ms (CAN) or 80 ms
// (Ethernet).
#pragma once
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

/// Loads these programs and holds their descriptors.
class ClosedPrograms {
 public:
  static Result<ClosedPrograms> of_can(const SharedMaps& shared);
  /// `wpan`: the frames are those of IEEE 802.15.4, not of Ethernet.
  static Result<ClosedPrograms> of_ethernet(const SharedMaps& shared, bool wpan);

  [[nodiscard]] int program_fd(Direction direction) const {
    return direction == Direction::ingress ? ingress_.get() : egress_.get();
  }

 private:
  ClosedPrograms(Fd ingress, Fd egress)
      : ingress_(std::move(ingress)), egress_(std::move(egress)) {}
  static Result<ClosedPrograms> keep(int ingress, int egress);
  Fd ingress_;
  Fd egress_;
};

}  // namespace mlcca::gates
