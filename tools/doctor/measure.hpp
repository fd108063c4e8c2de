// SPDX-License-Identifier: BSD-2-Clause
// Measurements with probe frames. An error means that a frame could not be sent or received at all.
#pragma once
#include <vector>

#include "base/result.hpp"
#include "tools/doctor/measured.hpp"
#include "tools/doctor/probe.hpp"

namespace mlcca::doctor {

/// Sends `count` frames one by one, each after the echo of the one before. Ends early if an echo is
/// missing.
Result<std::vector<Single>> send_singly(const Probe& probe, unsigned count);

/// How many frames take about kPassageNs back to back.
[[nodiscard]] unsigned frames_for_passage(const Probe& probe, const core::can::Timing& timing,
                                          bool fd);
inline constexpr core::can::Time kPassageNs = 500'000'000;
Result<Passage> send_back_to_back(const Probe& probe, unsigned count, bool fd);

/// Sends frames until the queue is full, at most `limit` and kMostBehind, then waits for their
/// echoes.
Result<Filling> fill(const Probe& probe, unsigned limit);
inline constexpr unsigned kMostBehind = 200;

/// Sends until the controller goes to bus-off, then waits for its recovery; `seconds` limits each.
Result<BusOff> await_bus_off(const Probe& probe, int ifindex, unsigned seconds);

}  // namespace mlcca::doctor
