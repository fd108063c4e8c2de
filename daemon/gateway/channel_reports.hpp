// SPDX-License-Identifier: BSD-2-Clause
// Channels and their deliveries as clients see them, and how large such a report is: what is large
// is not made in one turn of the loop.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/requests/asked.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_driver.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

class ChannelReports {
 public:
  /// All of them must outlive this.
  ChannelReports(const Scene& scene, const GateDriver& gates, const DeliveryHealth& health,
                 const DeliveryEvents& deliveries, const CanForwarding& forwarding,
                 const Meshes& meshes)
      : scene_(scene),
        gates_(gates),
        health_(health),
        deliveries_(deliveries),
        forwarding_(forwarding),
        meshes_(meshes) {}

  /// The verdicts of a channel that a client has asked for.
  [[nodiscard]] control::Channels known(const Asked& asked) const;
  /// Those that an admission takes part in.
  [[nodiscard]] control::Channels of_admission(core::AdmissionId id) const;
  /// Those of one publisher, or towards one subscriber, of a channel.
  [[nodiscard]] control::Channels of_publisher(std::size_t channel, std::size_t publisher) const;
  [[nodiscard]] control::Channels of_subscriber(std::size_t channel, std::size_t subscriber) const;
  /// Where a list of all deliveries goes on.
  struct Position {
    std::size_t channel = 0;
    std::size_t verdict = 0;
  };
  /// From there on, of one channel after the other: as many deliveries as there is time for in one
  /// turn.
  [[nodiscard]] serve::Slice some(Position& at) const;

  // Whether a report is too large for one turn of the loop:

  /// Of all that there is, whichever part of it a report lists.
  [[nodiscard]] bool is_large() const;
  [[nodiscard]] bool has_many_ends(std::size_t channel) const;
  [[nodiscard]] bool has_many_lines(std::size_t channel) const;
  [[nodiscard]] bool has_channel_of_many_ends() const;

 private:
  using Concerned = std::function<bool(const core::Verdict&)>;
  [[nodiscard]] control::Channels of_those(std::size_t channel, const Concerned& concerned) const;
  /// Some or all verdicts of one channel.
  [[nodiscard]] std::vector<control::Channel> report(
      const std::vector<const core::Verdict*>& verdicts) const;

  const Scene& scene_;
  const GateDriver& gates_;
  const DeliveryHealth& health_;
  const DeliveryEvents& deliveries_;
  const CanForwarding& forwarding_;
  const Meshes& meshes_;
};

}  // namespace mlcca
