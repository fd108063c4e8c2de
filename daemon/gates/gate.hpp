// SPDX-License-Identifier: BSD-2-Clause
// The gate of a CAN interface.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "daemon/gates/attachment.hpp"
#include "daemon/gates/bindings.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/port_gate.hpp"

namespace mlcca::enforce {

struct GateConfig {
  std::uint32_t ifindex = 0;
  std::string name;  ///< for error texts
  core::Profile profile = core::Profile::none;
  /// The device gives every frame it has sent back through ingress (IFF_ECHO: real controllers). Do
  /// not set it for a device whose frames come from another namespace (vxcan): marks cross there.
  bool echo_by_mark = false;
  std::optional<Hook> hook;  ///< the best one that the kernel has
  /// A program gets success for what is dropped at egress.
  bool silent = false;
};

class Gate final : public PortGate {
 public:
  /// Loads a gate and puts it in place. A gate of another profile is none of this kind. Errors: no
  /// such interface, no privilege, a foreign filter in our place.
  static Result<Gate> attach(const GateConfig& config, const Control& control);
  /// See PortGate::load().
  static Result<Gate> load(const GateConfig& config, const Control& control);

  [[nodiscard]] const GateConfig& config() const { return config_; }

  /// Frames that leave are put into bands by their identifiers: those up to the first limit
  /// (gate_arbitration()) into the first band, … at most GATE_BANDS - 1 limits, rising. No limits:
  /// they are left as they are.
  void set_bands(std::span<const std::uint32_t> limits);

  /// FAMOUSO: tags, and what their broker says of them.
  [[nodiscard]] Bindings bindings() const;

 private:
  Gate(PortGate loaded, GateConfig config);
  [[nodiscard]] gate_table& memory() const;
  GateConfig config_;
};

}  // namespace mlcca::enforce
