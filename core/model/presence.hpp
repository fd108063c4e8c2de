// SPDX-License-Identifier: BSD-2-Clause
// Gateways that announce their presence to each other, so that another one takes over when one
// fails.
#pragma once
#include <cstddef>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// The number of consecutive announcements that may be lost before a gateway counts as failed.
inline constexpr Value kPresenceLosses = 3;

/// The networks over which two gateways observe each other's presence: those where both have a port
/// and that accept subscriptions. Empty if one of the two does not announce itself.
[[nodiscard]] std::vector<std::size_t> presence_networks(const System& system, std::size_t gateway,
                                                         std::size_t other);

/// Upper limit, in ns, of the grace that counts: one hour. A longer grace of a gateway counts as
/// this one.
inline constexpr Value kLongestPresenceGrace = 3'600'000'000'000;

/// How long one announcement is valid, in ns: kPresenceLosses intervals plus the sender's grace,
/// since its gates keep their verdicts for the grace after its daemon has died. For example, an
/// interval of 0.5 s and a grace of 2 s give 3.5 s.
[[nodiscard]] Value presence_lasts(Value interval, Value grace);

}  // namespace mlcca::core
