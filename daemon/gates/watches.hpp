// SPDX-License-Identifier: BSD-2-Clause
// How the events of a slot are expected, and what the gate has found about them: gate_watch.
#pragma once
#include <cstdint>

#include "bpf/gate.h"
#include "daemon/gates/slots.hpp"

namespace mlcca::gates {

/// Sets what is expected. Findings under another period are forgotten, because they have no meaning
/// any more.
void expect_events(gate_watch& watch, const SlotSpec& spec);
/// Forgets the findings as if nothing had come yet: silence begins now, also where no timer
/// supervises it.
void forget_findings(gate_watch& watch);

/// What a watch has found so far. Times are in ns.
struct Arrivals {
  std::uint64_t events = 0;
  std::uint64_t missing = 0;     ///< including those that are missing now
  std::uint64_t since_last = 0;  ///< if nothing came yet: since the slot was opened
  std::uint64_t rate = 0;        ///< events in 1000 s, over the complete time; 0: unknown
  std::uint64_t last_gap = 0;    ///< 0: fewer than two events yet
  std::uint64_t shortest = 0;
  std::uint64_t longest = 0;
  std::uint64_t jitter = 0;
  std::uint64_t silence = 0;  ///< time after which it counts as silent; 0: never
  bool silent = false;
  std::uint64_t gaps[GATE_GAPS] = {};  // NOLINT(*-avoid-c-arrays): as in gate_watch
};
/// `now`: CLOCK_MONOTONIC, ns.
[[nodiscard]] Arrivals arrivals(const gate_watch& watch, std::uint64_t now);

}  // namespace mlcca::gates
