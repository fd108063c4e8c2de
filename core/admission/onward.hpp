// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions that a gateway passes on to the network that the events come from: other gateways
// there, which may have another description, must know what is required of their part of the way.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "core/model/members.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::core {

/// What the hops before must give, so that together with what the hops behind give (`used`, which
/// is composed of them) the requirement is fulfilled. Latency, Deadline and Jitter are what the
/// hops behind leave of them; an Omission of a before and b behind is (a + 1)(b + 1) - 1 together,
/// a loss of p and q is 1 - (1 - p)(1 - q); all others are required of every hop alike. Rounded to
/// the harder side. Nothing can be left: then it is 0, the hardest. For example of a Latency of 10
/// ms the hops behind take 3 ms: 7 ms are left.
[[nodiscard]] AttributeSet requirement_before(const AttributeSet& requirement,
                                              const AttributeSet& used);

/// What a gateway subscribes on a network, for all whom it passes the events on to.
struct OnwardSubscription {
  std::size_t channel = 0;
  std::size_t network = 0;
  AttributeSet required;
  /// Why it cannot be passed on, in words; empty: it can.
  std::string problem = {};
  /// For whom it is: described subscribers, those that were admitted, or both.
  bool described = false;
  std::vector<AdmissionId> admitted = {};
};

/// Deliveries of a channel that are looked at: with more nothing of it is passed on.
inline constexpr std::size_t kMostOnward = 256;

}  // namespace mlcca::core
