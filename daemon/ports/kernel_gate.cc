// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/kernel_gate.hpp"

namespace mlcca {
namespace {

template <class Gate>
Result<std::unique_ptr<HeldGate>> held(Result<Gate> loaded) {
  if (!loaded) return std::unexpected(loaded.error());
  return std::make_unique<KernelGate>(std::move(*loaded));
}

/// A gate has one profile, and fixed settings.
bool is_of(const gates::Gate& gate, const gates::GateConfig& config) {
  return gate.config().profile == config.profile &&
         gate.config().echo_by_mark == config.echo_by_mark && gate.config().silent == config.silent;
}

}  // namespace

Result<std::unique_ptr<HeldGate>> KernelGate::load(const GateSpec& spec,
                                                   const gates::Control& control) {
  if (const auto* const can = std::get_if<gates::GateConfig>(&spec))
    return held(gates::Gate::load(*can, control));
  return held(gates::EtherGate::load(std::get<gates::EtherConfig>(spec), control));
}

bool KernelGate::is(const GateSpec& spec) const {
  if (const auto* const can = std::get_if<gates::Gate>(&gate_)) {
    const auto* const config = std::get_if<gates::GateConfig>(&spec);
    return config != nullptr && is_of(*can, *config);
  }
  const auto* const config = std::get_if<gates::EtherConfig>(&spec);
  return config != nullptr && std::get<gates::EtherGate>(gate_).holds(*config);
}

gates::PortGate& KernelGate::port_gate() {
  return std::visit([](auto& gate) -> gates::PortGate& { return gate; }, gate_);
}

}  // namespace mlcca
