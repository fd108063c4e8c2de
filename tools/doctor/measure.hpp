// SPDX-License-Identifier: BSD-2-Clause
// Measurements with probe frames. Errors: a frame could not be sent or received at all.
#pragma once
#include <vector>

#include "base/result.hpp"
#include "tools/doctor/measured.hpp"
#include "tools/doctor/probe.hpp"

namespace mlcca::doctor {

/// Each is sent when the one before has come back; ends with one that does not.
Result<std::vector<Single>> send_singly(const Probe& probe, unsigned count);

/// So many that they take `kPassageNs`, back to back.
[[nodiscard]] unsigned frames_for_passage(const Probe& probe, const core::can::Timing& timing,
                                          bool fd);
inline constexpr core::can::Time kPassageNs = 500'000'000;
Result<Passage> send_back_to_back(const Probe& probe, unsigned count, bool fd);

/// As many as are taken, at most `limit` and `kMostBehind`; then waits until all have come back.
Result<Filling> fill(const Probe& probe, unsigned limit);
inline constexpr unsigned kMostBehind = 200;

/// Sends until a bus-off comes, and then waits for its end; each for so long.
Result<BusOff> await_bus_off(const Probe& probe, int ifindex, unsigned seconds);

}  // namespace mlcca::doctor
