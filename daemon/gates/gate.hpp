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

namespace mlcca::gates {

/// What the gate of an interface must be.
struct GateConfig {
  std::uint32_t ifindex = 0;
  std::string name;  ///< for error texts
  core::Profile profile = core::Profile::none;
  /// The device returns every frame that it has sent through ingress (IFF_ECHO: real controllers).
  /// Not to be set for a device whose frames come from another namespace (vxcan), because marks
  /// cross there.
  bool echo_by_mark = false;
  std::optional<Hook> hook;  ///< nullopt: the best one that the kernel has
  /// Programs get success for frames that are dropped at egress.
  bool silent = false;
};

/// See PortGate. Adds priority bands and FAMOUSO's tags.
class Gate final : public PortGate {
 public:
  /// Loads a gate and puts it in place. The slots of a gate with another profile are not taken
  /// over. Errors: no such interface, no privilege, a foreign filter in our place.
  static Result<Gate> attach(const GateConfig& config, const Control& control);
  /// See PortGate::load().
  static Result<Gate> load(const GateConfig& config, const Control& control);

  [[nodiscard]] const GateConfig& config() const { return config_; }

  /// Sets the band of frames that leave by their identifiers: frames up to the first limit
  /// (gate_arbitration()) are in the first band, and so on. At most GATE_BANDS - 1 limits, in
  /// rising order. Without limits frames are left as they are.
  void set_bands(std::span<const std::uint32_t> limits);

  /// The tags of FAMOUSO, and what the gate has found about them.
  [[nodiscard]] Bindings bindings() const;

 private:
  Gate(PortGate loaded, GateConfig config);
  [[nodiscard]] gate_table& memory() const;
  GateConfig config_;
};

}  // namespace mlcca::gates
