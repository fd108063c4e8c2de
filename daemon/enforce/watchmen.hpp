// SPDX-License-Identifier: BSD-2-Clause
// The timers that notice when a watched slot of one interface falls silent, and what the gate has
// found about its events.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "bpf/gate.h"
#include "core/handle.hpp"
#include "core/result.hpp"

struct watch_bpf;  // NOLINT(readability-identifier-naming): the skeleton's name

namespace mlcca::enforce {

void destroy_watchmen(watch_bpf* object);

/// Maps of the gate and the gateway that timers look at and write to; they stay the caller's.
struct WatchedMaps {
  int table = -1;
  int control = -1;
  int events = -1;
};

class Watchmen {
 public:
  /// Takes over the timers that are pinned there, which go on by the program that they have until
  /// they are armed; otherwise makes and pins new ones.
  static Result<Watchmen> load(std::uint32_t ifindex, const WatchedMaps& maps,
                               const std::string& pin_path);

  /// The timer of a slot whose gate_watch says what silence is. It ends by itself when the slot
  /// does not pass any more, or nobody minds silence. What is missing already is told once more.
  Result<void> arm(std::uint16_t slot) const;

 private:
  using Object = std::unique_ptr<watch_bpf, FreeWith<destroy_watchmen>>;
  explicit Watchmen(Object object) : object_(std::move(object)) {}
  Object object_;
};

/// What a watch has found so far. Times in ns.
struct Arrivals {
  std::uint64_t events = 0;
  std::uint64_t missing = 0;     ///< with those that are missing now
  std::uint64_t since_last = 0;  ///< nothing came yet: since silence began
  std::uint64_t rate = 0;        ///< events in 1000 s, over all of the time; 0: unknown
  std::uint64_t last_gap = 0;    ///< 0: not two events yet
  std::uint64_t shortest = 0;
  std::uint64_t longest = 0;
  std::uint64_t jitter = 0;
  bool silent = false;
  std::uint64_t gaps[GATE_GAPS] = {};  // NOLINT(*-avoid-c-arrays): as in gate_watch
};
/// `now`: CLOCK_MONOTONIC.
[[nodiscard]] Arrivals arrivals(const gate_watch& watch, std::uint64_t now);

}  // namespace mlcca::enforce
