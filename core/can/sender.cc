// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/sender.hpp"

#include <algorithm>

namespace mlcca::core::can {
namespace {

constexpr std::uint32_t kAddress = 0xff;

Time period_of(const Message& m) { return std::min(m.period, kLongestTime); }

/// The number of events that reach the sender in that time.
Time events_in(const Message& m, Time time) {
  return (time + m.jitter + period_of(m) - 1) / period_of(m);
}

}  // namespace

std::vector<std::size_t> of_same_sender(std::span<const Message> messages, std::size_t message) {
  const Message& m = messages[message];
  if (m.sender == kNoSender) return {message};
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < messages.size(); ++i)
    if (messages[i].sender == m.sender && messages[i].queue == m.queue) out.push_back(i);
  return out;
}

bool shares_address(std::span<const Message> messages, std::size_t message) {
  const Message& m = messages[message];
  return m.sender != kNoSender && std::ranges::any_of(messages, [&](const Message& other) {
           return other.sender != kNoSender && (other.sender & kAddress) == (m.sender & kAddress) &&
                  (other.sender != m.sender || other.queue != m.queue);
         });
}

std::optional<Time> busy_time(const Interference& all, const Overhead& overhead,
                              std::span<const Message> messages,
                              std::span<const std::size_t> members, const Level& level) {
  // Each frame is blocked once. Pauses occupy the sender as its frames occupy the bus.
  const auto whole = [&](const Message& m) {
    return m.transmission + m.pauses + m.frames * level.blocking;
  };
  Share share = all.share(0, level.end) + overhead.share(level.longest);
  Time begin = 0;
  for (const std::size_t i : members) {
    if (i < level.end) share -= all.share(i);
    share += share_of(std::min(whole(messages[i]), kLongestTime), period_of(messages[i]));
    begin = std::max(begin, messages[i].transmission);
  }
  if (share >= kAllShare) return std::nullopt;
  return fixpoint(begin, [&](Time t) {
    Time sum = overhead.until(t, t, level.longest) + all.demand(0, level.end, t - all.bit());
    for (const std::size_t i : members) {
      if (i < level.end) sum -= all.demand(i, i + 1, t - all.bit());
      sum += events_in(messages[i], t) * whole(messages[i]);
    }
    return sum;
  });
}

std::optional<Time> pausing_time(std::span<const Message> messages,
                                 std::span<const std::size_t> members) {
  Share share = 0;
  Time begin = 0;
  for (const std::size_t i : members) {
    share += share_of(messages[i].pauses, period_of(messages[i]));
    begin = std::max(begin, messages[i].pauses);
  }
  if (begin == 0) return 0;
  if (share >= kAllShare) return std::nullopt;
  return fixpoint(begin, [&](Time t) {
    Time sum = 0;
    for (const std::size_t i : members) sum += events_in(messages[i], t) * messages[i].pauses;
    return sum;
  });
}

}  // namespace mlcca::core::can
