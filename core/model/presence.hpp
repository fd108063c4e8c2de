// SPDX-License-Identifier: BSD-2-Clause
// Gateways that announce themselves to each other, so that another one takes the place of one that
// fails.
#pragma once
#include <cstddef>
#include <vector>

#include "core/model/system.hpp"

namespace mlcca::core {

/// Messages of a gateway that may be lost, one after the other, before it has failed.
inline constexpr Value kPresenceLosses = 3;

/// The networks over which two gateways know each other's presence: those of both that have
/// Subscriptions. None where one of them does not announce itself.
[[nodiscard]] std::vector<std::size_t> presence_networks(const System& system, std::size_t gateway,
                                                         std::size_t other);

/// A longer grace of a gateway counts as this one, ns: an hour.
inline constexpr Value kLongestPresenceGrace = 3'600'000'000'000;

/// For how long one message of a gateway says that it is there, ns: for kPresenceLosses intervals
/// and its grace, since its gates stay as they are for so long when its daemon dies. For example
/// 0.5 s and a grace of 2 s give 3.5 s.
[[nodiscard]] Value presence_lasts(Value interval, Value grace);

}  // namespace mlcca::core
