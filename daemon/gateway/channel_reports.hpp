// SPDX-License-Identifier: BSD-2-Clause
// Reports of channels and their deliveries for clients.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_reader.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

class ChannelReports {
 public:
  /// All references must outlive this object.
  ChannelReports(const Scene& scene, const GateReader& gates, const DeliveryHealth& health,
                 const DeliveryEvents& deliveries)
      : scene_(scene), gates_(gates), health_(health), deliveries_(deliveries) {}

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
};

}  // namespace mlcca
