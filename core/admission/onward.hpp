// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions that a gateway passes on towards the publisher. Other gateways there may have
// another description and must know what is required of their part of the route.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "core/model/members.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core {

class State;

/// What the hops before must provide so that the requirement is met together with the hops behind,
/// which provide `used` (their composition). Latency, Deadline and Jitter are reduced by what is
/// used. For Omission (a + 1)(b + 1) - 1 and for loss 1 - (1 - p)(1 - q) is solved for the first
/// term. All others are required of every hop alike. Results are rounded to the harder side; 0 (the
/// hardest) if nothing is left. Example: of a Latency of 10 ms the hops behind use 3 ms; 7 ms are
/// left.
[[nodiscard]] AttributeSet requirement_before(const AttributeSet& requirement,
                                              const AttributeSet& used);

/// The subscription of a gateway on a network, on behalf of all subscribers to which it forwards.
struct OnwardSubscription {
  std::size_t channel = 0;
  std::size_t network = 0;
  AttributeSet required;
  /// Why it cannot be passed on, as text; empty if it can.
  std::string problem = {};
  /// On whose behalf: described subscribers, admitted ones, or both.
  bool described = false;
  std::vector<AdmissionId> admitted = {};
};

/// The most deliveries of a channel that are considered. With more, no subscription is passed on.
inline constexpr std::size_t kMostOnward = 256;

/// What the gateway subscribes of a channel on its networks, for subscribers behind it or on it
/// that are granted: to the network that the events come from, where that accepts subscriptions.
/// Where they have come by another gateway of this description, that one knows who is described,
/// and subscribes for them itself.
[[nodiscard]] std::vector<OnwardSubscription> onward_of(State& state, std::size_t gateway,
                                                        std::size_t channel);

}  // namespace mlcca::core
