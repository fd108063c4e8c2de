// SPDX-License-Identifier: BSD-2-Clause
// Searches for priorities with which all messages meet their deadlines. A message that is in time
// at the lowest place, whatever the order above it, may be put there: if any order works, one with
// this message there works too (Audsley 2001).
#include <algorithm>
#include <numeric>

#include "core/can/analysis.hpp"
#include "core/can/level.hpp"

namespace mlcca::core::can {
namespace {

class Places {
 public:
  Places(const Assumptions& assumptions, std::span<const Message> messages)
      : overhead_(assumptions),
        messages_(messages),
        order_(messages.size()),
        all_(bit_time(assumptions.timing)) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    for (std::size_t i = 0; i < messages.size(); ++i) all_.insert(i, messages[i], offered(i));
  }

  /// Fills the places from the last to the first; returns false if no message fits one of them.
  bool fill() {
    Time longest_below = 0;
    for (std::size_t place = order_.size(); place-- > 0;) {
      if (!fill(place, longest_below)) return false;
      longest_below = std::max(longest_below, messages_[order_[place]].longest_frame);
    }
    return true;
  }
  [[nodiscard]] std::vector<std::size_t> take() && { return std::move(order_); }

 private:
  /// How late frames are offered (ns). If that depends on a response, which is unknown until the
  /// order above is known, it is taken to be as late as the deadline allows.
  [[nodiscard]] Time offered(std::size_t i) const {
    const Message& m = messages_[i];
    const Time deadline = std::min(m.deadline, kLongestTime);
    if (!is_coupled(m) || deadline < m.last_frame) return m.jitter;
    return std::max(m.jitter, deadline - m.last_frame);
  }

  bool fill(std::size_t place, Time longest_below) {
    Level level{.self = place,
                .end = place + 1,
                .blocking = overhead_.blocking(longest_below),
                .longest = 0};
    for (std::size_t i = 0; i <= place; ++i)
      level.longest = std::max(level.longest, messages_[order_[i]].longest_frame);
    // Tried from the last on, so that messages which are already in a good order are found at once.
    for (std::size_t tried = place + 1; tried-- > 0;) {
      swap(tried, place);
      const Message& m = messages_[order_[place]];
      const auto found = level_response(all_, overhead_, m, level, 0);
      if (found.bounded && found.response <= m.deadline) return true;
      swap(tried, place);
    }
    return false;
  }

  void swap(std::size_t a, std::size_t b) {
    std::swap(order_[a], order_[b]);
    all_.swap(a, b);
  }

  Overhead overhead_;
  std::span<const Message> messages_;
  std::vector<std::size_t> order_;  ///< index of the message at each place
  Interference all_;                ///< streams in that order
};

}  // namespace

std::optional<std::vector<std::size_t>> assign_priorities(const Assumptions& assumptions,
                                                          std::span<const Message> messages) {
  if (!std::ranges::all_of(messages, [&](const Message& m) { return usable(assumptions, m); }))
    return std::nullopt;
  Places places(assumptions, messages);
  if (!places.fill()) return std::nullopt;
  auto order = std::move(places).take();
  if (std::ranges::none_of(messages, is_coupled)) return order;

  // Queues were ignored so far, so the complete order is analysed.
  std::vector<Message> ordered;
  for (std::size_t place = 0; place < order.size(); ++place) {
    ordered.push_back(messages[order[place]]);
    ordered.back().priority = static_cast<std::uint32_t>(place);
  }
  const auto responses = analyse(assumptions, ordered);
  for (std::size_t i = 0; i < ordered.size(); ++i)
    if (!fits(assumptions, ordered[i], responses[i])) return std::nullopt;
  return order;
}

}  // namespace mlcca::core::can
