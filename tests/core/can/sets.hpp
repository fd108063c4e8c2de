// SPDX-License-Identifier: BSD-2-Clause
// Random messages for the tests of the analysis, always the same ones for a seed.
#pragma once
#include <array>
#include <random>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can::sets {

using Random = std::mt19937_64;

inline constexpr Time kMicrosecond = 1'000;
inline constexpr Time kMillisecond = 1'000'000;

inline std::uint64_t between(Random& random, std::uint64_t low, std::uint64_t high) {
  return low + random() % (high - low + 1);
}

/// What the messages of a set may be.
struct Kind {
  unsigned load = 70;  ///< percent of the bus, about
  bool jitter = true;
  bool several_frames = false;
  bool equal_priorities = false;
  unsigned queues = 0;  ///< about half of the messages are in one of these
};

inline Message message(std::uint64_t key, std::uint32_t priority, Time frame, Time period) {
  Message m;
  m.key = key;
  m.priority = priority;
  m.transmission = m.longest_frame = m.last_frame = frame;
  m.period = period;
  m.deadline = period;
  return m;
}

/// Messages at 500 kbit/s (2 us a bit) with keys from 0 on and priorities in random order.
inline std::vector<Message> random_set(Random& random, std::size_t count, const Kind& kind) {
  const Timing timing{.bitrate = 500'000};
  std::vector<Message> set;
  for (std::size_t i = 0; i < count; ++i) {
    Message m;
    m.key = i;
    m.priority = static_cast<std::uint32_t>(kind.equal_priorities ? random() % count : i);
    m.frames = kind.several_frames && random() % 3 == 0
                   ? static_cast<std::uint32_t>(between(random, 2, 4))
                   : 1;
    m.back_to_back = random() % 2 == 0;
    const FrameForm form{.extended = random() % 2 == 0};
    m.last_frame = frame_time(timing, form, static_cast<unsigned>(between(random, 0, 8)));
    m.longest_frame = m.frames == 1 ? m.last_frame : frame_time(timing, form, 8);
    m.transmission = (m.frames - 1) * m.longest_frame + m.last_frame;
    // Each takes about its part of the load, so periods are near each other and far apart by turns.
    const Time even = m.transmission * count * 100 / kind.load;
    m.period = even * between(random, 5, 20) / 10 + between(random, 0, 50) * kMicrosecond;
    m.jitter = kind.jitter && random() % 2 == 0 ? between(random, 0, m.period * 3 / 2) : 0;
    m.deadline = m.period * between(random, 5, 30) / 10 + m.jitter;
    if (kind.queues > 0 && random() % 2 == 0)
      m.queue = static_cast<std::uint32_t>(random() % kind.queues);
    set.push_back(m);
  }
  if (!kind.equal_priorities)
    for (std::size_t i = count; i-- > 1;)
      std::swap(set[i].priority, set[random() % (i + 1)].priority);
  return set;
}

}  // namespace mlcca::core::can::sets
