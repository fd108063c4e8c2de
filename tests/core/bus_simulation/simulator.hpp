// SPDX-License-Identifier: BSD-2-Clause
// A CAN bus frame by frame, fast enough for millions of buses. It shares nothing with the analysis
// but the description of the messages: arbitration, queues and errors are its own.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::testing::bus {

namespace can = core::can;
using can::Time;

/// Small and fast, and the same everywhere (Marsaglia, "Xorshift RNGs", 2003).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15U | 1U) {
    for (int i = 0; i < 4; ++i) next();
  }
  std::uint64_t next() {
    state_ ^= state_ << 13U;
    state_ ^= state_ >> 7U;
    state_ ^= state_ << 17U;
    return state_ * 0x2545f4914f6cdd1dU >> 16U;
  }
  std::uint64_t below(std::uint64_t n) { return next() % n; }
  std::uint64_t between(std::uint64_t low, std::uint64_t high) {
    return low + below(high - low + 1);
  }
  bool one_in(std::uint64_t n) { return below(n) == 0; }

 private:
  std::uint64_t state_;
};

/// When a message's events are released and how late they are offered.
enum class Phases : std::uint8_t {
  random,    ///< anything that period and jitter allow
  together,  ///< first offered at `first`, as late as the jitter allows, then as fast as it may
  never,
};
struct Plan {
  Phases phases = Phases::random;
  Time first = 0;
};

enum class Errors : std::uint8_t {
  none,
  random,   ///< each frame may be hit
  longest,  ///< each frame that is hit is one of the longest, at its end
  always,   ///< each frame is hit at its end, as often as errors may occur
};

struct World {
  std::size_t victim = 0;     ///< of events that come at one moment, its own come last
  bool one_at_a_time = true;  ///< senders of fragmented events offer the next frame too late
  bool unadmitted = false;    ///< a frame of the longest form waits at the lowest priority, always
  Time unadmitted_from = 0;   ///< from then on
  Errors errors = Errors::none;
  unsigned most_frames = 200;  ///< then the run ends
  Time idle_after = 0;         ///< a bus that is idle after that is done
};

struct Observed {
  std::vector<Time> response;              ///< longest of each message; 0: none was sent
  std::vector<std::uint32_t> most_queued;  ///< of each queue, controller included
  unsigned frames = 0;
  unsigned errors = 0;
};

Observed run(const can::Assumptions& assumptions, std::span<const can::Message> messages,
             std::span<const Plan> plans, const World& world, Random& random);

}  // namespace mlcca::testing::bus
