// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/schedule.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/can/level.hpp"

namespace mlcca::core::can {
namespace {

std::pair<std::uint32_t, std::uint64_t> rank(const Message& m) { return {m.priority, m.key}; }

/// Iterates over the messages from the lowest priority upwards and keeps the level of each.
class Upwards {
 public:
  Upwards(std::span<const Message> messages, const Interference& all, const Overhead& overhead)
      : messages_(messages), all_(all), overhead_(overhead), end_(messages.size()) {
    for (std::size_t i = 0; i < messages.size(); ++i) {
      share_ += all.share(i);
      fixed_ += all.fixed(i);
    }
    if (overhead.none()) return;
    longest_to_.assign(messages.size() + 1, 0);
    for (std::size_t i = 0; i < messages.size(); ++i)
      longest_to_[i + 1] = std::max(longest_to_[i], messages[i].longest_frame);
  }

  /// Moves to message i, which must be the one above the last one asked for. `added` does not count
  /// as what blocked before.
  void move_to(std::size_t i, std::size_t added = SIZE_MAX) {
    if (i + 1 == messages_.size() || messages_[i].priority == messages_[i + 1].priority) return;
    for (; end_ > i + 1; --end_) {
      share_ -= all_.share(end_ - 1);
      fixed_ -= all_.fixed(end_ - 1);
      const Time frame = messages_[end_ - 1].longest_frame;
      longest_below_ = std::max(longest_below_, frame);
      if (end_ - 1 != added) longest_before_ = std::max(longest_before_, frame);
    }
  }
  [[nodiscard]] Level level(std::size_t i) const {
    return {.self = i,
            .end = end_,
            .blocking = overhead_.blocking(longest_below_),
            .longest = longest_to_.empty() ? 0 : longest_to_[end_]};
  }
  /// Whether the added message blocks the messages of this level for longer than others did.
  [[nodiscard]] bool blocks_longer() const {
    return overhead_.blocking(longest_below_) > overhead_.blocking(longest_before_);
  }
  /// Whether straight lines above the demand of all others already show that message i is in time.
  [[nodiscard]] bool plainly_in_time(std::size_t i, Time blocking) const {
    const Message& m = messages_[i];
    const Time taken = m.jitter + m.last_frame;
    const Time deadline = std::min(m.deadline, kLongestTime);
    const Time second = std::min(m.period, kLongestTime);
    if (deadline < taken || second < taken || share_ >= kAllShare) return false;
    const Time fixed = blocking + m.transmission + fixed_ - all_.fixed(i);
    return fits_line(fixed - m.last_frame, i, deadline - taken) &&
           fits_line(fixed, i, second - m.jitter);
  }

 private:
  [[nodiscard]] bool fits_line(Time fixed, std::size_t i, Time until) const {
    __extension__ using Product = unsigned __int128;
    const Share free = kAllShare - (share_ - all_.share(i));
    return Product{fixed} << kShareBits <= Product{free} * until;
  }

  std::span<const Message> messages_;
  const Interference& all_;
  const Overhead& overhead_;
  std::size_t end_;  ///< index behind the messages of the same priority
  Share share_ = 0;  ///< of all streams before end_
  Time fixed_ = 0;   ///< ns, of all streams before end_
  Time longest_below_ = 0;
  Time longest_before_ = 0;  ///< the same without the added message
  std::vector<Time> longest_to_;
};

}  // namespace

Schedule::Schedule(Assumptions assumptions) : assumptions_(std::move(assumptions)) { rebuild(); }

std::optional<Schedule::Late> Schedule::add(const Message& message) {
  if (!settled_) return late().front();
  if (!usable(assumptions_, message))
    return Late{.key = message.key, .deadline = message.deadline, .jitter = message.jitter};
  const auto at = static_cast<std::size_t>(
      std::ranges::lower_bound(messages_, rank(message), {}, rank) - messages_.begin());
  insert(at, message);
  auto late = coupled_ > 0 ? check_coupled() : check_alone(at);
  if (late) erase(at);
  return late;
}

/// Whether all are in time after a message was added, if each has a queue of its own. Returns one
/// that is late.
std::optional<Schedule::Late> Schedule::check_alone(std::size_t added) {
  const Overhead overhead(assumptions_);
  Upwards walk(messages_, interference_, overhead);
  std::vector<std::pair<std::size_t, Time>> learnt;
  for (std::size_t i = messages_.size(); i-- > 0;) {
    walk.move_to(i, added);
    const Level level = walk.level(i);
    const Message& m = messages_[i];
    if (is_spared(m)) continue;
    // Messages above the new one are affected only if it blocks them for longer.
    const bool above = level.end <= added;
    if (above && !walk.blocks_longer()) continue;
    if (overhead.none() &&
        (walk.plainly_in_time(i, level.blocking) || surely_in_time(interference_, m, level)))
      continue;
    const Time taken = m.jitter + m.last_frame;
    const Time begin = at_least_[i] > taken ? at_least_[i] - taken : 0;
    const LevelResponse found = level_response(interference_, overhead, m, level, begin);
    if (!found.bounded || found.response > m.deadline)
      return late_of(i, {.response = found.response, .bounded = found.bounded});
    learnt.emplace_back(i, found.first + taken);
  }
  for (const auto& [i, response] : learnt) at_least_[i] = response;
  return std::nullopt;
}

std::optional<Schedule::Late> Schedule::check_coupled() {
  const auto responses = all_responses();
  for (std::size_t i = 0; i < messages_.size(); ++i)
    if (!is_spared(messages_[i]) && !fits(assumptions_, messages_[i], responses[i]))
      return late_of(i, responses[i]);
  std::ranges::transform(responses, at_least_.begin(), &Response::response);
  return std::nullopt;
}

void Schedule::remove(std::uint64_t key) {
  const std::size_t at = position_of(key);
  if (at == messages_.size()) return;
  erase(at);
  if (!spared_.empty()) std::erase(spared_, key);
  // Bounds may become smaller now, so the old ones are no lower bounds any more.
  std::ranges::fill(at_least_, 0);
  if (!settled_) {
    rebuild();
    settled_ = late().empty();
  }
}

const Message* Schedule::find(std::uint64_t key) const {
  const std::size_t at = position_of(key);
  return at == messages_.size() ? nullptr : &messages_[at];
}

Time Schedule::response(std::uint64_t key) const {
  const std::size_t at = position_of(key);
  if (at == messages_.size()) return kNever;
  if (coupled_ > 0 || !settled_) {
    const Response found = all_responses()[at];
    return found.bounded ? found.response : kNever;
  }
  const Overhead overhead(assumptions_);
  Upwards walk(messages_, interference_, overhead);
  for (std::size_t i = messages_.size(); i-- > at;) walk.move_to(i);
  const LevelResponse found =
      level_response(interference_, overhead, messages_[at], walk.level(at), 0);
  return found.bounded ? found.response : kNever;
}

std::vector<Schedule::Late> Schedule::set_assumptions(Assumptions assumptions) {
  assumptions_ = std::move(assumptions);
  rebuild();
  auto found = late();
  settled_ = found.empty();
  return found;
}

std::vector<Schedule::Late> Schedule::late() const {
  const auto responses = all_responses();
  std::vector<Late> found;
  for (std::size_t i = 0; i < messages_.size(); ++i)
    if (!is_spared(messages_[i]) && !fits(assumptions_, messages_[i], responses[i]))
      found.push_back(late_of(i, responses[i]));
  return found;
}

void Schedule::put(std::span<const Message> messages) {
  if (messages.empty()) return;
  std::vector<std::uint64_t> fresh;
  fresh.reserve(messages.size());
  for (const Message& m : messages) fresh.push_back(m.key);
  std::ranges::sort(fresh);
  messages_.insert(messages_.end(), messages.begin(), messages.end());
  std::ranges::sort(messages_, {}, rank);
  rebuild();
  // A message that cannot be analysed is not spared, because then nothing is known of the bus.
  for (const Late& late : late())
    if (std::ranges::binary_search(fresh, late.key) && usable(assumptions_, *find(late.key)))
      spared_.push_back(late.key);
  std::ranges::sort(spared_);
  settled_ = late().empty();
}

std::vector<Schedule::Late> Schedule::spared() const {
  if (spared_.empty()) return {};
  const auto responses = all_responses();
  std::vector<Late> found;
  for (std::size_t i = 0; i < messages_.size(); ++i)
    if (is_spared(messages_[i])) found.push_back(late_of(i, responses[i]));
  return found;
}

void Schedule::review() {
  if (spared_.empty()) return;
  const auto responses = all_responses();
  for (std::size_t i = 0; i < messages_.size(); ++i)
    if (fits(assumptions_, messages_[i], responses[i])) std::erase(spared_, messages_[i].key);
}

std::uint64_t Schedule::utilisation_ppm() const {
  return can::utilisation_ppm(assumptions_, messages_);
}

std::size_t Schedule::position_of(std::uint64_t key) const {
  return static_cast<std::size_t>(std::ranges::find(messages_, key, &Message::key) -
                                  messages_.begin());
}

Schedule::Late Schedule::late_of(std::size_t at, const Response& response) const {
  const Message& m = messages_[at];
  Late late{.key = m.key,
            .response = response.response,
            .bounded = response.bounded,
            .deadline = m.deadline,
            .jitter = m.jitter};
  if (m.queue >= assumptions_.queues.size()) return late;
  late.queued = response.queued_frames;
  late.length = assumptions_.queues[m.queue].length;
  late.overflow = response.bounded && late.queued > late.length;
  return late;
}

std::vector<Response> Schedule::all_responses() const {
  return analyse_from(assumptions_, messages_, at_least_);
}

void Schedule::insert(std::size_t at, const Message& message) {
  const auto offset = static_cast<std::ptrdiff_t>(at);
  messages_.insert(messages_.begin() + offset, message);
  at_least_.insert(at_least_.begin() + offset, 0);
  interference_.insert(at, message, message.jitter);
  if (is_coupled(message)) ++coupled_;
}

void Schedule::erase(std::size_t at) {
  const auto offset = static_cast<std::ptrdiff_t>(at);
  if (is_coupled(messages_[at])) --coupled_;
  messages_.erase(messages_.begin() + offset);
  at_least_.erase(at_least_.begin() + offset);
  if (interference_.size() > at) interference_.erase(at);
}

/// Rebuilds the arrays of the analysis from messages and assumptions. Without a bit rate, or with a
/// message that cannot be analysed, they stay empty: nothing can be added until that is corrected.
void Schedule::rebuild() {
  at_least_.assign(messages_.size(), 0);
  coupled_ = static_cast<std::size_t>(std::ranges::count_if(messages_, is_coupled));
  interference_ = Interference(bit_time(assumptions_.timing));
  if (!std::ranges::all_of(messages_, [&](const Message& m) { return usable(assumptions_, m); }))
    return;
  for (std::size_t i = 0; i < messages_.size(); ++i)
    interference_.insert(i, messages_[i], messages_[i].jitter);
}

}  // namespace mlcca::core::can
