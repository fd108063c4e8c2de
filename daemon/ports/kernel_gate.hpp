// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <memory>
#include <utility>
#include <variant>

#include "daemon/gates/control.hpp"
#include "daemon/ports/held_gate.hpp"

namespace mlcca {

/// A gate of either kind in the kernel.
class KernelGate final : public HeldGate {
 public:
  /// See gates::PortGate::load().
  static Result<std::unique_ptr<HeldGate>> load(const GateSpec& spec,
                                                const gates::Control& control);
  template <class Gate>
  explicit KernelGate(Gate gate) : gate_(std::move(gate)) {}

  [[nodiscard]] bool is(const GateSpec& spec) const override;
  Result<void> put() override { return port_gate().put(); }
  Result<void> reattach() override { return port_gate().reattach(); }
  void deny_all() override { port_gate().deny_all(); }
  void unpin() override { port_gate().unpin(); }
  [[nodiscard]] gates::PortGate& port_gate() override;
  [[nodiscard]] gates::Gate* can_gate() override { return std::get_if<gates::Gate>(&gate_); }

 private:
  std::variant<gates::Gate, gates::EtherGate> gate_;
};

}  // namespace mlcca
