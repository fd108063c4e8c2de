// SPDX-License-Identifier: BSD-2-Clause
// How often the relay wakes up while much arrives.
#pragma once
#include <algorithm>
#include <cstdint>

namespace mlcca::relay {

/// Lets events gather for a moment while they arrive fast, as network cards delay their interrupts:
/// waking up for each event is a third of what the relay costs. Example: four buses of 1 Mbit/s
/// bring 31 events in a millisecond. The relay then sleeps for 0.2 ms between two rounds, and finds
/// six events in each.
///
/// Events pass without a pause while fewer than `kMany` interfaces are ready in a millisecond. A
/// pause takes at most a quarter of the shortest Latency.
class Pace {
 public:
  static constexpr std::uint64_t kPause = 200'000;     ///< ns
  static constexpr std::uint64_t kWindow = 1'000'000;  ///< ns over which arrivals are counted
  static constexpr unsigned kMany = 16;       ///< ready interfaces in a window: pauses begin
  static constexpr unsigned kFew = 8;         ///< fewer than these: pauses end
  static constexpr std::uint64_t kShare = 4;  ///< a pause is at most this part of a Latency

  /// To be called after each round. `ready`: interfaces that had events in it. `now`:
  /// CLOCK_MONOTONIC in ns. `shortest`: the shortest Latency that an event may take, in ns; 0: none
  /// is stated. Returns how long to sleep before the next round, in ns.
  std::uint64_t after_round(unsigned ready, std::uint64_t now, std::uint64_t shortest) {
    ready_ += ready;
    if (now - since_ >= kWindow) {
      fast_ = now - since_ < 2 * kWindow && ready_ >= (fast_ ? kFew : kMany);
      since_ = now;
      ready_ = 0;
    }
    if (!fast_) return 0;
    return shortest == 0 ? kPause : std::min(kPause, shortest / kShare);
  }

 private:
  std::uint64_t since_ = 0;
  unsigned ready_ = 0;
  bool fast_ = false;
};

}  // namespace mlcca::relay
