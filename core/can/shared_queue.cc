// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/shared_queue.hpp"

#include <algorithm>

namespace mlcca::core::can {

/// What is sent from an earlier moment to the start of an event's last frame.
struct SharedQueue::Case {
  Time before = 0;       ///< ns of frames ahead at that moment, blocking included
  Range at_arrival{};    ///< members whose events count if they were queued before the event
  Range until_start{};   ///< members that overtake the event
  bool carried = false;  ///< frames of other senders may have waited at that moment already
};

SharedQueue::SharedQueue(const Streams& streams, const Overhead& overhead,
                         std::vector<std::size_t> members, unsigned depth, std::size_t end,
                         Time blocking)
    : streams_(streams),
      overhead_(overhead),
      members_(std::move(members)),
      depth_(depth),
      end_(end),
      blocking_(blocking) {
  std::size_t next = 0;
  for (const std::size_t member : members_) {
    if (next < member) others_.push_back({next, member});
    next = member + 1;
    longest_member_ = std::max(longest_member_, streams.messages[member].longest_frame);
  }
  if (next < end_) others_.push_back({next, end_});
  for (const Message& m : streams.messages.first(end_))
    longest_ = std::max(longest_, m.longest_frame);
}

Time SharedQueue::others(const Case& c, Time until) const {
  Time sum = 0;
  for (const auto& [first, last] : others_) {
    if (!c.carried) {
      sum += streams_.interference.demand(first, last, until);
      continue;
    }
    for (std::size_t i = first; i < last; ++i)
      sum += streams_.interference.demand_of(i, until, streams_.responses[i]);
  }
  return sum;
}

Time SharedQueue::demand_of(Range range, Time until) const {
  Time sum = 0;
  for (std::size_t i = range.first; i < range.last; ++i)
    sum +=
        streams_.interference.demand_of(members_[i], until, streams_.messages[members_[i]].jitter);
  return sum;
}

Time SharedQueue::queued_by(const Case& c, Time arrival) const {
  Time sum = 0;
  for (std::size_t i = c.at_arrival.first; i < c.at_arrival.last; ++i) {
    const Message& m = streams_.messages[members_[i]];
    sum += streams_.interference.events(members_[i], arrival, m.jitter) * m.transmission;
  }
  return sum;
}

Share SharedQueue::share_of(Range range) const {
  Share sum = 0;
  for (std::size_t i = range.first; i < range.last; ++i)
    sum += streams_.interference.share(members_[i]);
  return sum;
}

std::optional<Time> SharedQueue::longest_wait(const Case& c, Time last_frame) const {
  Share share = overhead_.share(longest_) + share_of(c.at_arrival) + share_of(c.until_start);
  for (const auto& [first, last] : others_) share += streams_.interference.share(first, last);
  if (share >= kAllShare) return std::nullopt;

  const Time bit = streams_.interference.bit();
  const auto busy = fixpoint(c.before + bit, [&](Time t) {
    return c.before + overhead_.until(t, t, longest_) + others(c, t - bit) +
           demand_of(c.at_arrival, t - bit) + demand_of(c.until_start, t - bit);
  });
  if (!busy) return std::nullopt;

  // While an event waits, only overtaking frames are added later, so the longest wait is that of an
  // event which is queued at the same moment as another one. These moments are tried in order.
  std::vector<Time> next;
  for (std::size_t i = c.at_arrival.first; i < c.at_arrival.last; ++i) {
    const Message& m = streams_.messages[members_[i]];
    const Time period = std::min(m.period, kLongestTime);
    next.push_back((m.jitter / period + 1) * period - m.jitter);
  }
  Time longest = 0;
  Time start = 0;
  Time arrival = 0;
  for (std::uint64_t tried = 0; arrival < *busy; ++tried) {
    if (tried > kMaxInstances) return std::nullopt;
    const Time queued = c.before + queued_by(c, arrival) - last_frame;
    const auto found = fixpoint(std::max(start, queued), [&](Time w) {
      return queued + overhead_.until(w, w + last_frame, longest_) + others(c, w) +
             demand_of(c.until_start, w);
    });
    if (!found) return std::nullopt;
    start = *found;
    if (start > arrival) longest = std::max(longest, start - arrival);

    arrival = *std::ranges::min_element(next);
    for (std::size_t i = 0; i < next.size(); ++i)
      if (next[i] == arrival)
        next[i] +=
            std::min(streams_.messages[members_[c.at_arrival.first + i]].period, kLongestTime);
  }
  return longest;
}

std::optional<Time> SharedQueue::wait(unsigned band, Time last_frame) const {
  const auto band_of = [&](std::size_t member) { return streams_.bands[member]; };
  const auto same = std::ranges::equal_range(members_, band, {}, band_of);
  const auto first = static_cast<std::size_t>(same.begin() - members_.begin());
  const auto last = static_cast<std::size_t>(same.end() - members_.begin());

  // First bound: since the queue was empty, everything that came before counts, of any band.
  const auto since_empty = longest_wait(
      {.before = blocking_, .at_arrival = {first, members_.size()}, .until_start = {0, first}},
      last_frame);
  if (last == members_.size()) return since_empty;

  // Second bound: since no frame of this band or a better one waited, what the controller held then
  // counts, and only better bands after that. Frames of other senders may have been waiting.
  for (const auto& [from, to] : others_)
    for (std::size_t i = from; i < to; ++i)
      if (streams_.responses[i] == kNever) return since_empty;
  const auto since_served = longest_wait({.before = blocking_ + depth_ * longest_member_,
                                          .at_arrival = {first, last},
                                          .until_start = {0, first},
                                          .carried = true},
                                         last_frame);
  if (!since_empty || !since_served) return since_empty ? since_empty : since_served;
  return std::min(*since_empty, *since_served);
}

}  // namespace mlcca::core::can
