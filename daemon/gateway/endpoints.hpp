// SPDX-License-Identifier: BSD-2-Clause
// Reports where programs on this gateway send granted events, and where they receive them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "control/messages.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gateway/local_ends.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/port_facts.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca {

class Endpoints {
 public:
  /// All references must outlive this object.
  Endpoints(const Scene& scene, const PortFacts& gates, const LocalEnds& local_ends)
      : scene_(scene), gates_(gates), local_ends_(local_ends) {}

  /// Where a publisher that is a program here sends. Empty if nothing of it is granted.
  [[nodiscard]] std::vector<control::Endpoint> of_publisher(std::size_t channel,
                                                            std::size_t publisher) const;
  /// Where a subscriber that is a program here receives.
  [[nodiscard]] std::vector<control::Endpoint> of_subscriber(std::size_t channel,
                                                             std::size_t subscriber) const;

  /// The addresses for subscriptions on a network of this gateway that accepts them.
  [[nodiscard]] control::SubscriptionNetwork of_subscriptions(std::size_t port) const;

  /// Adds what programs carry from network to network of one channel; with `user`, only what that
  /// user's programs carry.
  void add_transfers(std::size_t channel, std::optional<std::uint32_t> user,
                     control::Transfers& to) const;
  /// Adds the transfers of all channels to the reply for `mlccactl routes`.
  void add_to(control::Routes& to) const;
  /// The transfers of all channels from `at` on, which is advanced: as many as one turn has time
  /// for.
  [[nodiscard]] serve::Slice some_transfers(std::size_t& at,
                                            std::optional<std::uint32_t> user) const;

 private:
  [[nodiscard]] std::vector<core::Passage> passages(std::size_t channel) const;
  [[nodiscard]] const core::Network& network_at(std::size_t port) const;
  /// The part of an endpoint that is the same for all channels of the port; nullopt if the port has
  /// no gate now.
  [[nodiscard]] std::optional<control::Endpoint> at_port(std::size_t port) const;
  /// nullopt if the port of the entry has no gate now.
  [[nodiscard]] std::optional<control::Endpoint> endpoint(std::size_t channel,
                                                          const core::GateEntry& entry,
                                                          std::uint32_t event_bytes) const;
  /// Sums up what programs here send, by user, and how it is supervised.
  class FromPrograms;
  [[nodiscard]] std::uint32_t event_bytes(const core::Passage& passage) const;

  const Scene& scene_;
  const PortFacts& gates_;
  const LocalEnds& local_ends_;
};

}  // namespace mlcca
