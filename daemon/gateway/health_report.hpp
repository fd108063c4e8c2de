// SPDX-License-Identifier: BSD-2-Clause
// The health of the complete gateway, with reasons, for people and for monitoring systems.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reloads.hpp"
#include "daemon/gateway/safeguards.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/outside/gate_control.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

/// Collects the problems of all parts of the gateway.
class HealthReport {
 public:
  /// All references must outlive this object.
  struct Parts {
    const Scene& scene;
    const GateDriver& gates;
    const GateControl& control;
    const LinkMonitor& links;
    const Meshes& meshes;
    const Recorder& recorder;
    const CanForwarding& forwarding;
    const Safeguards& safeguards;
    const Reloads& reloads;
    const TagBindings& tags;
    const Admissions& admissions;
    const DeliveryHealth& deliveries;
    const GatewayPresence& presence;
    const Clock& clock;
    const Modes& modes;
    const Membership* membership = nullptr;  ///< null: the gateway is not in a cluster
  };
  explicit HealthReport(const Parts& parts) : parts_(parts) {}

  /// The gates had closed because no heart-beat came, and have opened again now. This counts as a
  /// problem for some time.
  void note_lapse() { lapsed_ = parts_.clock.monotonic_s(); }
  /// The health of the gateway. `interfaces` is the result of GateDriver::report().
  [[nodiscard]] control::Health health(const std::vector<control::Interface>& interfaces) const;
  /// The problems that keep the gateway from doing its work, most serious first.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  void add_own(std::vector<std::string>& to) const;

  Parts parts_;
  std::optional<std::int64_t> lapsed_;  ///< CLOCK_MONOTONIC in s of the latest note_lapse()
};

}  // namespace mlcca
