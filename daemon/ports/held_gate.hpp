// SPDX-License-Identifier: BSD-2-Clause
// An interface for a gate that was loaded for one interface, for use by GateSet: the kernel's
// (KernelGate), or a fake.
#pragma once
#include "base/result.hpp"
#include "daemon/ports/gate_spec.hpp"

namespace mlcca {

class HeldGate {
 public:
  HeldGate() = default;
  HeldGate(const HeldGate&) = delete;
  HeldGate& operator=(const HeldGate&) = delete;
  HeldGate(HeldGate&&) = delete;
  HeldGate& operator=(HeldGate&&) = delete;
  virtual ~HeldGate() = default;

  /// Whether the gate need not be replaced by one that is loaded by `spec`.
  [[nodiscard]] virtual bool is(const GateSpec& spec) const = 0;

  // See gates::PortGate.

  virtual Result<void> put() = 0;
  virtual Result<void> reattach() = 0;
  virtual void deny_all() = 0;
  virtual void unpin() = 0;

  /// The gate itself, for its slots and counters.
  [[nodiscard]] virtual gates::PortGate& port_gate() = 0;
  /// The gate if it is a CAN gate; nullptr otherwise.
  [[nodiscard]] virtual gates::Gate* can_gate() = 0;
};

}  // namespace mlcca
