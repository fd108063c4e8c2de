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
bool is_of(const enforce::Gate& gate, const enforce::GateConfig& config) {
  return gate.config().profile == config.profile &&
         gate.config().echo_by_mark == config.echo_by_mark && gate.config().silent == config.silent;
}

}  // namespace

Result<std::unique_ptr<HeldGate>> KernelGate::load(const GateSpec& spec,
                                                   const enforce::Control& control) {
  if (const auto* const can = std::get_if<enforce::GateConfig>(&spec))
    return held(enforce::Gate::load(*can, control));
  return held(enforce::EtherGate::load(std::get<enforce::EtherConfig>(spec), control));
}

bool KernelGate::is(const GateSpec& spec) const {
  if (const auto* const can = std::get_if<enforce::Gate>(&gate_)) {
    const auto* const config = std::get_if<enforce::GateConfig>(&spec);
    return config != nullptr && is_of(*can, *config);
  }
  const auto* const config = std::get_if<enforce::EtherConfig>(&spec);
  return config != nullptr && std::get<enforce::EtherGate>(gate_).holds(*config);
}

enforce::PortGate& KernelGate::port_gate() {
  return std::visit([](auto& gate) -> enforce::PortGate& { return gate; }, gate_);
}

}  // namespace mlcca
