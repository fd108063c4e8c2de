// SPDX-License-Identifier: BSD-2-Clause
// What an interface gets before there is a daemon: programs without tables, which let pass what a
// closed gate lets pass. The kernel has checked them in a millisecond or two, a gate in 13 (CAN) or
// 80 (Ethernet).
#pragma once
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/slots.hpp"

namespace mlcca::enforce {

class ClosedPrograms {
 public:
  static Result<ClosedPrograms> of_can(const SharedMaps& shared);
  /// `wpan`: frames of IEEE 802.15.4, not of Ethernet.
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

}  // namespace mlcca::enforce
