// SPDX-License-Identifier: BSD-2-Clause
// A CAN bus frame by frame: what the analysis bounds must hold here, whatever the phases. It shares
// nothing with the analysis but the description of the messages.
#pragma once
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can::simulation {

/// One event of a message.
struct Event {
  std::size_t message = 0;
  Time release = 0;          ///< nominal
  std::vector<Time> queued;  ///< of each frame, rising, at most release + jitter
};

/// How malicious the world is.
struct World {
  Time duration = 0;          ///< events are released before
  bool late_blocker = false;  ///< a frame of the longest form waits at the lowest priority, always
  unsigned error_chance = 0;  ///< percent of the frames that are hit where an error may occur
  bool background_wins = true;  ///< background frames have the highest priority, else the lowest
};

struct Observed {
  std::vector<Time> response;              ///< longest of each message; 0: none was sent
  std::vector<std::uint32_t> most_queued;  ///< of each queue, controller included
  std::uint64_t frames = 0;
  std::uint64_t errors = 0;
};

using Random = std::mt19937_64;

/// Events of all messages over the duration, with random phases, jitter and gaps.
std::vector<Event> random_events(std::span<const Message> messages, Time duration, Random& random);

/// The critical instant of one message: it and all that win against it are queued at the same
/// moment, as late as their jitter allows, a bit time after the longest of the others has begun,
/// and then come as fast as they may.
std::vector<Event> critical_events(std::span<const Message> messages, std::size_t victim,
                                   Time duration, Time bit);

/// Sends the events. `bands` as of bands_of(). The last frame of an event takes last_frame, all
/// others longest_frame.
Observed run(const Assumptions& assumptions, std::span<const Message> messages,
             std::span<const unsigned> bands, std::span<const Event> events, const World& world,
             Random& random);

}  // namespace mlcca::core::can::simulation
