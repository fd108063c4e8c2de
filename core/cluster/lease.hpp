// SPDX-License-Identifier: BSD-2-Clause
// For how long a beat lets a gateway send, and when others may be sure that it does not send any
// more. Each side counts on a clock of its own; the two need not agree in anything but their rate
// (docs/explanation/cluster.md). Times in ns.
#pragma once
#include "mlcca/attribute.hpp"

namespace mlcca::core::cluster {

/// By how much the rate of any clock may be wrong, ppm.
inline constexpr Value kClockError = 1000;
/// For how long a frame that was handed to a queue may still be sent.
inline constexpr Value kQueued = 1'000'000'000;
/// Leases that a gateway may have. Others believe none that is longer.
inline constexpr Value kLeastLease = 2'000'000'000;
inline constexpr Value kMostLease = 3'600'000'000'000;

/// Until when a gateway may send, on its own clock, that handed a beat over at `sent`, once the
/// beat is known to be committed. Rounded down.
[[nodiscard]] Value valid_until(Value sent, Value lease);
/// When another gateway may fence it, and count it as silent once it is fenced, on the clock of
/// that other one, which received the beat at `seen`. Rounded up.
[[nodiscard]] Value may_fence_at(Value seen, Value lease);
/// When nothing that was handed to a queue before `closed` is sent any more. Rounded up.
[[nodiscard]] Value queues_empty_at(Value closed);

}  // namespace mlcca::core::cluster
