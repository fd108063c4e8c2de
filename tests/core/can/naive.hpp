// SPDX-License-Identifier: BSD-2-Clause
// The analysis once more, straight from the formulas of Davis et al. 2007 (equations 4, 8 to 12),
// without any economy: for messages of one frame with queues of their own.
#pragma once
#include <algorithm>
#include <optional>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can::naive {

inline Time ceiling(Time a, Time b) { return (a + b - 1) / b; }

inline std::optional<Time> response(const std::vector<Message>& set, std::size_t m, Time bit) {
  constexpr Time far = 1'000'000'000'000;
  const Message& self = set[m];
  Time blocking = 0;
  for (const Message& k : set)
    if (k.priority > self.priority) blocking = std::max(blocking, k.transmission);
  double load = 0;
  for (const Message& k : set)
    if (k.priority <= self.priority)
      load += static_cast<double>(k.transmission) / static_cast<double>(k.period);
  if (load >= 1) return std::nullopt;

  Time busy = self.transmission;
  while (true) {
    Time next = blocking;
    for (const Message& k : set)
      if (k.priority <= self.priority) next += ceiling(busy + k.jitter, k.period) * k.transmission;
    if (next > far) return std::nullopt;
    if (next == busy) break;
    busy = next;
  }
  Time worst = 0;
  const Time instances = ceiling(busy + self.jitter, self.period);
  for (Time q = 0; q < instances; ++q) {
    Time start = blocking + q * self.transmission;
    while (true) {
      Time next = blocking + q * self.transmission;
      for (std::size_t k = 0; k < set.size(); ++k)
        if (k != m && set[k].priority <= self.priority)
          next += ceiling(start + set[k].jitter + bit, set[k].period) * set[k].transmission;
      if (next == start) break;
      start = next;
    }
    const Time end = self.jitter + start + self.transmission;
    if (end > q * self.period) worst = std::max(worst, end - q * self.period);
  }
  return worst;
}

}  // namespace mlcca::core::can::naive
