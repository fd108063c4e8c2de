// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/cover.hpp"

#include <algorithm>
#include <tuple>

#include "core/can/level.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::can {
namespace {

/// The time that the bus may take, counted from when all frames wait; kNever if unlimited.
Time delay_of(const Message& m) {
  if (m.deadline == kNever) return kNever;
  return m.deadline > m.jitter ? m.deadline - m.jitter : 0;
}

}  // namespace

bool covers(const Message& promised, const Message& wanted) {
  const auto kind = [](const Message& m) {
    return std::tuple(m.frames, m.back_to_back, m.queue, m.least_pause, m.sender);
  };
  return kind(promised) == kind(wanted) && promised.priority <= wanted.priority &&
         lowest_of(promised) >= lowest_of(wanted) && promised.transmission >= wanted.transmission &&
         promised.longest_frame >= wanted.longest_frame &&
         promised.last_frame <= wanted.last_frame && promised.period <= wanted.period &&
         promised.jitter >= wanted.jitter && promised.pauses >= wanted.pauses &&
         delay_of(promised) <= delay_of(wanted);
}

Message strictest(const Message& a, const Message& b) {
  Message m = a;
  m.priority = std::min(a.priority, b.priority);
  const std::uint32_t lowest = std::max(lowest_of(a), lowest_of(b));
  m.lowest_priority = lowest > m.priority ? lowest : a.lowest_priority;
  m.frames = std::max(a.frames, b.frames);
  m.back_to_back = a.back_to_back && b.back_to_back;
  m.transmission = std::max(a.transmission, b.transmission);
  m.longest_frame = std::max(a.longest_frame, b.longest_frame);
  m.last_frame = std::min(a.last_frame, b.last_frame);
  m.period = std::min(a.period, b.period);
  m.jitter = std::max(a.jitter, b.jitter);
  m.least_pause = std::min(a.least_pause, b.least_pause);
  m.pauses = std::max(a.pauses, b.pauses);
  m.deadline = add_saturating(m.jitter, std::min(delay_of(a), delay_of(b)));
  return m;
}

}  // namespace mlcca::core::can
