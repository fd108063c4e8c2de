// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/level.hpp"

namespace mlcca::core::can {
namespace {

// What one error costs on the bus beside the frame that is sent again: at most 31 bit times from
// the error to the next start of frame (Davis, Burns, Bril and Lukkien: Controller Area Network
// (CAN) schedulability analysis: refuted, revisited and revised, Real-Time Systems 35, 2007).
constexpr unsigned kErrorFrameBits = 31;
constexpr Time kMillionth = 1'000'000;

/// The time that blocks `frames` frames, each one separately, until `until`, counted from the start
/// of the busy period.
Time blocked(const Level& level, Time frames, Time until) {
  const Time each = level.blocking * frames;
  return level.blockers == nullptr ? each : std::min(each, level.blockers->until(until));
}

/// The share of bus time by which each further event is blocked.
Share blocked_share(const Message& m, const Level& level) {
  if (!one_at_a_time(m)) return 0;
  const Share each = share_of(level.blocking * m.frames, std::min(m.period, kLongestTime));
  return level.blockers == nullptr ? each : std::min(each, level.blockers->share());
}

}  // namespace

Unusable unusable(const Assumptions& assumptions, const Message& m) {
  const Time bit = bit_time(assumptions.timing);
  constexpr std::uint32_t most_frames = 1U << 16U;
  if (bit == kNever) return Unusable::bit_rate;
  if (m.period <= 1) return Unusable::period;
  if (m.frames < 1 || m.frames > most_frames) return Unusable::frames;
  if (m.last_frame < bit || m.last_frame > m.longest_frame || m.longest_frame > m.transmission ||
      m.transmission > kLongestTime || m.pauses > kLongestTime)
    return Unusable::transmission;
  if (m.queue != kOwnQueue && m.queue >= assumptions.queues.size()) return Unusable::queue;
  if (m.jitter > kLongestTime) return Unusable::jitter;
  return Unusable::no;
}

bool is_coupled(const Message& m) {
  return m.queue != kOwnQueue || one_at_a_time(m) || lowest_of(m) > m.priority;
}

Overhead::Overhead(const Assumptions& a)
    : plain_(a.background == 0 && a.faults.count == 0),
      longest_(can::longest_frame(a.timing, a.fd_frames, a.xl_frames)),
      error_frame_(kErrorFrameBits * bit_time(a.timing)),
      background_(a.background),
      faults_{.count = a.faults.count,
              .interval = std::clamp<Time>(a.faults.interval, 1, kLongestTime)} {
  if (a.faults.count > 0) least_blocking_ = error_frame_;
  if (a.unknown_senders) least_blocking_ = std::max(least_blocking_, longest_);
}

Time Overhead::background(Time t) const {
  if (background_ == 0) return 0;
  return longest_ + (t * background_ + kMillionth - 1) / kMillionth;
}

Time Overhead::errors(Time t, Time longest) const {
  if (faults_.count == 0) return 0;
  // The frame that has to be repeated may be one of the background.
  const Time spoilt = background_ > 0 ? std::max(longest, longest_) : longest;
  const Time intervals = (t + faults_.interval - 1) / faults_.interval;
  return (error_frame_ + spoilt) * faults_.count * intervals;
}

Share Overhead::share(Time longest) const {
  if (plain_) return 0;
  Share share = share_of(std::min<Time>(background_, kMillionth), kMillionth);
  if (faults_.count > 0) {
    const Time spoilt = background_ > 0 ? std::max(longest, longest_) : longest;
    const Time each = error_frame_ + spoilt;
    if (faults_.count >= kLongestTime / each) return kAllShare;
    share += share_of(each * faults_.count, faults_.interval);
  }
  return share;
}

LevelResponse level_response(const Interference& all, const Overhead& overhead, const Message& m,
                             const Level& level, Time begin) {
  const Share share = all.share(0, level.end) + overhead.share(level.longest);
  if (share >= kAllShare) return {};
  const auto others = [&](Time until) {
    return all.demand(0, level.self, until) + all.demand(level.self + 1, level.end, until);
  };
  const Time frames = one_at_a_time(m) ? m.frames : 0;  // of an event, each blocked once
  const Time once = frames > 0 ? 0 : level.blocking;
  const auto start_of = [&](Time events, Time from) {
    const Time own = once + events * m.transmission - m.last_frame;
    return fixpoint(std::max(from, own), [&](Time w) {
      return own + blocked(level, frames * events, w) +
             overhead.until(w, w + m.last_frame, level.longest) + others(w);
    });
  };
  const auto first = start_of(1, begin);
  if (!first) return {};

  const Time period = std::min(m.period, kLongestTime);
  // The busy period ends when everything that was offered before its end has been sent.
  const auto busy_until = [&](Time t) {
    const Time events = (t + m.jitter + period - 1) / period;
    return events * m.transmission + once + blocked(level, frames * events, t) +
           overhead.until(t, t, level.longest) + others(t - all.bit());
  };
  const Time second = period > m.jitter ? period - m.jitter : 0;
  const Time end_of_first = *first + m.last_frame;
  Time events = 1;
  // As a rule a message has one event in its busy period; one check of the second release shows
  // that.
  if (second < end_of_first || busy_until(second) > second) {
    // What blocks further events must leave room for the next one.
    if (share + blocked_share(m, level) >= kAllShare) return {};
    const auto busy = fixpoint(end_of_first, busy_until);
    if (!busy) return {};
    events = (*busy + m.jitter + period - 1) / period;
  }
  if (events > kMaxInstances) return {};

  LevelResponse found{.bounded = true, .response = m.jitter + end_of_first, .first = *first};
  Time start = *first;
  for (Time event = 1; event < events; ++event) {
    const auto next = start_of(event + 1, start + m.last_frame);
    if (!next) return {};
    start = *next;
    const Time since = event * period;
    if (m.jitter + start + m.last_frame > since)
      found.response = std::max(found.response, m.jitter + start + m.last_frame - since);
  }
  return found;
}

bool surely_in_time(const Interference& all, const Message& m, const Level& level) {
  const Time taken = m.jitter + m.last_frame;
  const Time last_start = std::min(m.deadline, kLongestTime);
  const Time second = std::min(m.period, kLongestTime);
  if (last_start < taken || second < taken || all.share(0, level.end) >= kAllShare) return false;
  const auto others = [&](Time until) {
    return all.demand(0, level.self, until) + all.demand(level.self + 1, level.end, until);
  };
  const Time own = m.transmission + (one_at_a_time(m) ? m.frames : 1) * level.blocking;
  const Time start = last_start - taken;
  if (own - m.last_frame + others(start) > start) return false;
  const Time end = second - m.jitter;  // of the busy period, before the second event is queued
  return end >= all.bit() && own + others(end - all.bit()) <= end;
}

}  // namespace mlcca::core::can
