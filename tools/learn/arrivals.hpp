// SPDX-License-Identifier: BSD-2-Clause
// The Period and the Jitter of events that come at random, so that a gate passes also those that
// were not recorded. A gate (GCRA) is a queue that serves an event in each Period: an event is
// early by its waiting time there.
#pragma once
#include <cstdint>

#include "tools/learn/flow.hpp"

namespace mlcca::learn {

/// One event of so many may be earlier than jitter_of_queue().
inline constexpr std::uint64_t kOneOf = 100'000;

/// The longest Period (ns) for the events of an aperiodic flow, which has gaps: three quarters of
/// the shortest mean gap that it may have, which is two standard errors below the one that was
/// seen:
///   3/4 * mean * (1 - 2 * c / sqrt(n))
/// for n gaps with the coefficient of variation c (1 for a Poisson process; smaller ones count as
/// 1). The parenthesis is 1/4 at least.
[[nodiscard]] std::uint64_t longest_period(const Flow& flow);

/// The Jitter (ns) with which at most one of kOneOf events exceeds `period` (ns), if gaps are
/// independent of each other. By the inequality of Kingman (Inequalities in the theory of queues,
/// J. R. Stat. Soc. B 32, 1970) an event waits longer than J with a probability of at most
/// e^(-t*J), where t > 0 solves E[e^(t * (period - gap))] = 1. UINT64_MAX if the mean gap is not
/// longer than the Period.
[[nodiscard]] std::uint64_t jitter_of_queue(const Flow& flow, std::uint64_t period);

/// The mean gap (ns) less two standard errors, of any flow that has gaps.
[[nodiscard]] std::uint64_t shortest_mean(const Flow& flow);

/// The longest Period (ns) that a cyclic flow can have: its events come so often in the long run.
/// That is the mean time between events, counted with those that were lost, plus what the ends of
/// the recording may be wrong by, plus half of what a gate allows for clocks.
[[nodiscard]] std::uint64_t longest_cycle(const Flow& flow);

}  // namespace mlcca::learn
