// SPDX-License-Identifier: BSD-2-Clause
// Reports of channels and their deliveries for clients, and estimates of whether such a report is
// too large to be made in one turn of the loop.
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
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_reader.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

class ChannelReports {
 public:
  /// All references must outlive this object.
  ChannelReports(const Scene& scene, const GateReader& gates, const DeliveryHealth& health,
                 const DeliveryEvents& deliveries, const CanForwarding& forwarding,
                 const Meshes& meshes)
      : scene_(scene),
        gates_(gates),
        health_(health),
        deliveries_(deliveries),
        forwarding_(forwarding),
        meshes_(meshes) {}

  /// The verdicts that concern the question of a client.
  [[nodiscard]] control::Channels known(const ParsedRequest& asked) const;
  /// The verdicts in which an admission takes part.
  [[nodiscard]] control::Channels of_admission(core::AdmissionId id) const;
  /// The verdicts of one publisher, or towards one subscriber, of a channel.
  [[nodiscard]] control::Channels of_publisher(std::size_t channel, std::size_t publisher) const;
  [[nodiscard]] control::Channels of_subscriber(std::size_t channel, std::size_t subscriber) const;
  /// Where some() continues in the list of all deliveries.
  struct Position {
    std::size_t channel = 0;
    std::size_t verdict = 0;
  };
  /// The next part of the list of all deliveries, from `at` on, which is advanced: as many as one
  /// turn has time for.
  [[nodiscard]] serve::Slice some(Position& at) const;

  // Whether a report is too large for one turn of the loop:

  /// A report of everything, also if it lists only a part.
  [[nodiscard]] bool is_large() const;
  [[nodiscard]] bool has_many_ends(std::size_t channel) const;
  [[nodiscard]] bool has_many_lines(std::size_t channel) const;
  [[nodiscard]] bool has_channel_of_many_ends() const;

 private:
  using Concerned = std::function<bool(const core::Verdict&)>;
  [[nodiscard]] control::Channels of_those(std::size_t channel, const Concerned& concerned) const;
  /// Reports the given verdicts, all of one channel.
  [[nodiscard]] std::vector<control::Channel> report(
      const std::vector<const core::Verdict*>& verdicts) const;

  const Scene& scene_;
  const GateReader& gates_;
  const DeliveryHealth& health_;
  const DeliveryEvents& deliveries_;
  const CanForwarding& forwarding_;
  const Meshes& meshes_;
};

}  // namespace mlcca
