// SPDX-License-Identifier: BSD-2-Clause
// The health of the whole gateway, with reasons, for people and for monitoring systems.
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

class HealthReport {
 public:
  /// All of them must outlive this.
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
    const Membership* membership = nullptr;  ///< null: it shares nothing by a store
  };
  explicit HealthReport(const Parts& parts) : parts_(parts) {}

  /// The gates had closed for want of a heart-beat, and follow the verdicts again since now.
  void note_lapse() { lapsed_ = parts_.clock.monotonic_s(); }
  /// `interfaces`: as GateDriver::report() gives them.
  [[nodiscard]] control::Health health(const std::vector<control::Interface>& interfaces) const;
  /// What keeps the gateway from doing its work, the most serious first.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  void add_own(std::vector<std::string>& to) const;

  Parts parts_;
  std::optional<std::int64_t> lapsed_;  ///< until when, the latest time, CLOCK_MONOTONIC, s
};

}  // namespace mlcca
