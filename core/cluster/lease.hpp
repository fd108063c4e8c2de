// SPDX-License-Identifier: BSD-2-Clause
// Leases: how long a beat allows a gateway to send, and when others can be sure that it no longer
// sends. Each side uses its own clock; only the rates of the clocks must agree, within kClockError
// (docs/explanation/cluster.md, "The lease and the death rule"). Times are in ns.
#pragma once
#include "mlcca/attribute.hpp"

namespace mlcca::core::cluster {

/// The largest error of the rate of a clock, in ppm.
inline constexpr Value kClockError = 1000;
/// How long a frame may still be sent after it entered a queue.
inline constexpr Value kQueued = 1'000'000'000;
/// The shortest and the longest lease of a gateway. Others do not believe a longer one.
inline constexpr Value kLeastLease = 2'000'000'000;
inline constexpr Value kMostLease = 3'600'000'000'000;

/// Until when a gateway may send whose beat was handed over at `sent` on its own clock, once the
/// beat is known to be committed: sent + lease - 0.1 %, rounded down.
[[nodiscard]] Value valid_until(Value sent, Value lease);
/// From when another gateway, which saw the beat at `seen` on its own clock, may fence the sender,
/// and may count it as silent once it is fenced: seen + lease + 0.1 % + kQueued, rounded up.
[[nodiscard]] Value may_fence_at(Value seen, Value lease);
/// When no frame is sent any more that entered a queue before `closed`, rounded up.
[[nodiscard]] Value queues_empty_at(Value closed);

}  // namespace mlcca::core::cluster
