// SPDX-License-Identifier: BSD-2-Clause
// The health of the complete gateway, with reasons, for people and for monitoring systems.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
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
#include "daemon/outside/gate_reader.hpp"
#include "daemon/outside/link_monitor.hpp"

namespace mlcca {

/// Why the kernel has closed all gates by itself.
enum class Lapse : std::uint8_t {
  heartbeat,  ///< the daemon gave no heart-beat for longer than the grace
  lease,      ///< the store has confirmed no beat of the gateway until its lease ended
};
/// What people read after "because". `grace` is how it is called, or its value with its unit.
std::string words_of(Lapse reason, const std::string& grace);

/// Collects the problems of all parts of the gateway.
class HealthReport {
 public:
  /// All references must outlive this object.
  struct Parts {
    const Scene& scene;
    const GateReader& gates;
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

  /// The gates had closed by themselves, and have opened again now. This counts as a problem for
  /// some time.
  void note_lapse(Lapse reason) { lapse_ = {reason, parts_.clock.monotonic_s()}; }
  /// The health of the gateway. `interfaces` is the result of PortFacts::report().
  [[nodiscard]] control::Health health(const std::vector<control::Interface>& interfaces) const;
  /// The problems that keep the gateway from doing its work, most serious first.
  [[nodiscard]] std::vector<std::string> problems() const;

 private:
  void add_own(std::vector<std::string>& to) const;

  Parts parts_;
  /// Of the latest note_lapse(), with its time: CLOCK_MONOTONIC, s.
  std::optional<std::pair<Lapse, std::int64_t>> lapse_;
};

}  // namespace mlcca
