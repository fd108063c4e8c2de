// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/analysis.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/can/level.hpp"
#include "core/can/sender.hpp"
#include "core/can/shared_queue.hpp"

namespace mlcca::core::can {
namespace {

/// Whether the load of the message is known, although its jitter may be too long.
bool has_load(const Assumptions& assumptions, const Message& m) {
  const Unusable why = unusable(assumptions, m);
  return why == Unusable::no || why == Unusable::jitter;
}

std::vector<std::size_t> by_priority(std::span<const Message> messages) {
  std::vector<std::size_t> order(messages.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(
      order, {}, [&](std::size_t i) { return std::pair(messages[i].priority, messages[i].key); });
  return order;
}

/// Analyses all messages of a bus together. Bounds that depend on each other are raised, from
/// values that are too small, until all equations hold.
class Analysis {
 public:
  Analysis(const Assumptions& assumptions, std::vector<Message> sorted, std::vector<unsigned> bands,
           std::vector<Time> at_least);
  std::vector<Response> run() &&;

 private:
  void make_senders();
  void make_queues(const Assumptions& assumptions);
  [[nodiscard]] std::size_t end_of(std::uint32_t priority) const;
  [[nodiscard]] Time blocking(std::uint32_t priority) const;
  [[nodiscard]] bool depends_on_unbounded(std::size_t end) const { return unbounded_ < end; }
  [[nodiscard]] std::optional<Blockers> blockers_of(std::size_t i) const;
  bool round();
  void update_alone(std::size_t i);
  void update_queue(std::size_t q);
  void raise(std::size_t i, Time response);
  [[nodiscard]] std::uint32_t most_queued(const SharedQueue& queue) const;

  Overhead overhead_;
  std::vector<Message> messages_;
  std::vector<unsigned> bands_;
  std::vector<Time> responses_;
  std::vector<Time> first_start_;
  std::vector<std::size_t> ends_;
  std::vector<Time> blocking_;
  std::vector<Time> longest_to_;  ///< longest frame (ns) of the messages before each index
  Streams streams_;
  std::vector<SharedQueue> queues_;
  /// Per message with pauses and a queue of its own: the indices of all messages of its sender.
  std::vector<std::vector<std::size_t>> same_sender_;
  std::vector<bool> stale_;  ///< per message with a queue of its own: must be analysed again
  std::vector<bool> queue_stale_;
  /// Messages that are blocked before each frame, if nothing else is on the bus than messages.
  std::vector<std::size_t> blocked_per_frame_;
  std::size_t unbounded_;  ///< first message that makes all those it affects unbounded
};

Analysis::Analysis(const Assumptions& assumptions, std::vector<Message> sorted,
                   std::vector<unsigned> bands, std::vector<Time> at_least)
    : overhead_(assumptions),
      messages_(std::move(sorted)),
      bands_(std::move(bands)),
      responses_(std::move(at_least)),
      first_start_(messages_.size(), 0),
      longest_to_(messages_.size() + 1, 0),
      streams_{.messages = messages_,
               .responses = responses_,
               .bands = bands_,
               .interference = Interference(bit_time(assumptions.timing))},
      same_sender_(messages_.size()),
      stale_(messages_.size(), true),
      unbounded_(messages_.size()) {
  make_senders();
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    Message& m = messages_[i];
    if (m.jitter > kLongestTime) {
      // Any number of its frames may arrive at once, so what it wins against is not bounded.
      m.jitter = kLongestTime;
      responses_[i] = kNever;
      unbounded_ = std::min(unbounded_, i);
    }
    responses_[i] = std::max(responses_[i], m.jitter + m.transmission);
    const Time offered =
        is_coupled(m) && responses_[i] != kNever ? responses_[i] - m.last_frame : m.jitter;
    streams_.interference.insert(i, m, offered);
    longest_to_[i + 1] = std::max(longest_to_[i], m.longest_frame);
    std::uint32_t lowest = lowest_of(m);
    for (const std::size_t k : same_sender_[i]) lowest = std::max(lowest, lowest_of(messages_[k]));
    ends_.push_back(end_of(lowest));
    blocking_.push_back(blocking(lowest));
    if (one_at_a_time(m) && overhead_.none() && !assumptions.unknown_senders)
      blocked_per_frame_.push_back(i);
  }
  make_queues(assumptions);
}

/// The pauses of a gateway end before the frames enter its queue, so they are jitter of the queue.
void Analysis::make_senders() {
  std::vector<Time> late(messages_.size(), 0);
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    const Message& m = messages_[i];
    if (m.sender == kNoSender && m.pauses == 0) continue;
    if (shares_address(messages_, i)) late[i] = kNever;
    if (m.pauses == 0 || late[i] == kNever) continue;
    auto members = of_same_sender(messages_, i);
    if (m.queue == kOwnQueue)
      same_sender_[i] = std::move(members);
    else
      late[i] = pausing_time(messages_, members).value_or(kNever);
  }
  for (std::size_t i = 0; i < messages_.size(); ++i)
    messages_[i].jitter = late[i] == kNever ? kNever : messages_[i].jitter + late[i];
}

void Analysis::make_queues(const Assumptions& assumptions) {
  queues_.reserve(assumptions.queues.size());
  for (std::size_t q = 0; q < assumptions.queues.size(); ++q) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < messages_.size(); ++i)
      if (messages_[i].queue == q) members.push_back(i);
    if (members.empty()) continue;
    std::uint32_t lowest = 0;
    for (const std::size_t i : members) lowest = std::max(lowest, lowest_of(messages_[i]));
    queues_.emplace_back(streams_, overhead_, std::move(members), assumptions.queues[q].fifo_depth,
                         end_of(lowest), blocking(lowest));
  }
  queue_stale_.assign(queues_.size(), true);
}

/// The index behind all messages that may win against this priority.
std::size_t Analysis::end_of(std::uint32_t priority) const {
  const auto end = std::ranges::upper_bound(messages_, priority, {}, &Message::priority);
  return static_cast<std::size_t>(end - messages_.begin());
}

/// The longest frame (ns) of lower priority, which may block this one.
Time Analysis::blocking(std::uint32_t priority) const {
  Time longest = 0;
  for (const Message& m : messages_)
    if (lowest_of(m) > priority) longest = std::max(longest, m.longest_frame);
  return overhead_.blocking(longest);
}

/// Raises a bound (kNever: not bounded) and marks what depends on it as stale.
void Analysis::raise(std::size_t i, Time response) {
  if (response <= responses_[i]) return;
  responses_[i] = response;
  const bool coupled = is_coupled(messages_[i]);
  if (coupled && response == kNever) unbounded_ = std::min(unbounded_, i);
  if (coupled && response != kNever)
    streams_.interference.set_jitter(i, response - messages_[i].last_frame);
  // The bounds of a queue, and of a message that is blocked before each frame, depend on the bounds
  // of all messages. Those of any other message depend only on when the frames of others are
  // offered.
  for (const std::size_t k : blocked_per_frame_)
    if (k != i) stale_[k] = true;
  if (coupled)
    for (std::size_t k = 0; k < messages_.size(); ++k)
      if (k != i && i < ends_[k]) stale_[k] = true;
  for (std::size_t q = 0; q < queues_.size(); ++q)
    if (i < queues_[q].end()) queue_stale_[q] = true;
}

/// What may block a message that is blocked before each frame; nullopt if that is not bounded.
std::optional<Blockers> Analysis::blockers_of(std::size_t i) const {
  if (std::ranges::find(blocked_per_frame_, i) == blocked_per_frame_.end()) return std::nullopt;
  Blockers all;
  for (std::size_t k = 0; k < messages_.size(); ++k) {
    if (k == i || lowest_of(messages_[k]) <= lowest_of(messages_[i])) continue;
    if (responses_[k] == kNever) return std::nullopt;
    all.add(messages_[k], responses_[k]);
  }
  return all;
}

void Analysis::update_alone(std::size_t i) {
  stale_[i] = false;
  const auto blockers = blockers_of(i);
  const Level level{.self = i,
                    .end = ends_[i],
                    .blocking = blocking_[i],
                    .longest = longest_to_[ends_[i]],
                    .blockers = blockers ? &*blockers : nullptr};
  LevelResponse found;
  if (depends_on_unbounded(ends_[i])) {
    // Stays unbounded.
  } else if (messages_[i].pauses > 0) {
    const auto busy =
        busy_time(streams_.interference, overhead_, messages_, same_sender_[i], level);
    if (busy) found = {.bounded = true, .response = messages_[i].jitter + *busy, .first = 0};
  } else {
    found = level_response(streams_.interference, overhead_, messages_[i], level, first_start_[i]);
  }
  first_start_[i] = found.first;
  raise(i, found.bounded && found.response <= kLongestTime ? found.response : kNever);
}

void Analysis::update_queue(std::size_t q) {
  const SharedQueue& queue = queues_[q];
  queue_stale_[q] = false;
  struct Known {
    unsigned band;
    Time last_frame;
    std::optional<Time> wait;
  };
  std::vector<Known> known;  // a wait depends on nothing else
  for (const std::size_t i : queue.members()) {
    const Message& m = messages_[i];
    auto it = std::ranges::find_if(
        known, [&](const Known& k) { return k.band == bands_[i] && k.last_frame == m.last_frame; });
    if (it == known.end()) {
      std::optional<Time> wait;
      if (!depends_on_unbounded(queue.end())) wait = queue.wait(bands_[i], m.last_frame);
      it = known.insert(it, {bands_[i], m.last_frame, wait});
    }
    const Time response = it->wait ? m.jitter + *it->wait + m.last_frame : kNever;
    raise(i, response <= kLongestTime ? response : kNever);
  }
}

/// Analyses what is stale; returns whether there was anything.
bool Analysis::round() {
  bool any = false;
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    if (messages_[i].queue != kOwnQueue || !stale_[i] || responses_[i] == kNever) continue;
    update_alone(i);
    any = true;
  }
  for (std::size_t q = 0; q < queues_.size(); ++q) {
    if (!queue_stale_[q]) continue;
    update_queue(q);
    any = true;
  }
  return any;
}

std::uint32_t Analysis::most_queued(const SharedQueue& queue) const {
  // An event occupies the queue from its nominal release for at most its response time.
  constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
  std::uint64_t frames = 0;
  for (const std::size_t i : queue.members()) {
    if (responses_[i] == kNever) return most;
    const Message& m = messages_[i];
    const Time period = std::min(m.period, kLongestTime);
    std::uint64_t most_there = (responses_[i] + period - 1) / period * m.frames;
    if (m.least_pause > 0) {
      // Frames enter the queue apart from each other: count those that entered since the first.
      // Frames that come from another bus may be closer to each other, by at most its jitter.
      const Time nearer = m.pauses > 0 ? 0 : m.jitter;
      most_there = std::min(most_there, 1 + (responses_[i] - m.jitter + nearer) / m.least_pause);
    }
    frames += most_there;
  }
  return static_cast<std::uint32_t>(std::min(frames, most));
}

std::vector<Response> Analysis::run() && {
  unsigned rounds = 0;
  while (round())
    if (++rounds > kMaxRounds) {
      std::ranges::fill(responses_, kNever);
      break;
    }
  std::vector<Response> found;
  found.reserve(messages_.size());
  for (const Time response : responses_)
    found.push_back({.response = response == kNever ? 0 : response, .bounded = response != kNever});
  for (const SharedQueue& queue : queues_) {
    const std::uint32_t frames = most_queued(queue);
    for (const std::size_t i : queue.members()) found[i].queued_frames = frames;
  }
  return found;
}

}  // namespace

std::vector<unsigned> bands_of(const Assumptions& assumptions, std::span<const Message> messages) {
  std::vector<unsigned> bands(messages.size(), 0);
  struct Last {
    std::uint32_t lowest = 0;  ///< of the frames in the band
    bool any = false;
    unsigned band = 0;
  };
  std::vector<Last> last(assumptions.queues.size());
  for (const std::size_t i : by_priority(messages)) {
    const Message& m = messages[i];
    if (m.queue >= last.size()) continue;
    const Queue& queue = assumptions.queues[m.queue];
    if (queue.queueing != Queueing::priority) continue;
    Last& l = last[m.queue];
    if (l.any && l.lowest < m.priority)
      l.band = std::min(l.band + 1, std::max(queue.bands, 1U) - 1);
    l.any = true;
    l.lowest = std::max(l.lowest, lowest_of(m));
    bands[i] = l.band;
  }
  return bands;
}

std::vector<Response> analyse(const Assumptions& assumptions, std::span<const Message> messages) {
  return analyse_from(assumptions, messages, {});
}

std::vector<Response> analyse_from(const Assumptions& assumptions,
                                   std::span<const Message> messages,
                                   std::span<const Time> at_least) {
  std::vector<Response> found(messages.size());
  if (!std::ranges::all_of(messages, [&](const Message& m) { return has_load(assumptions, m); })) {
    for (std::size_t i = 0; i < messages.size(); ++i)
      if (messages[i].queue != kOwnQueue)
        found[i].queued_frames = std::numeric_limits<std::uint32_t>::max();
    return found;
  }
  const auto order = by_priority(messages);
  const auto bands = bands_of(assumptions, messages);
  std::vector<Message> sorted;
  std::vector<unsigned> sorted_bands;
  std::vector<Time> sorted_least;
  for (const std::size_t i : order) {
    sorted.push_back(messages[i]);
    sorted_bands.push_back(bands[i]);
    sorted_least.push_back(at_least.empty() ? 0 : at_least[i]);
  }
  const auto responses =
      Analysis(assumptions, std::move(sorted), std::move(sorted_bands), std::move(sorted_least))
          .run();
  for (std::size_t i = 0; i < order.size(); ++i) found[order[i]] = responses[i];
  return found;
}

bool fits(const Assumptions& assumptions, const Message& message, const Response& response) {
  return response.meets(message.deadline) &&
         (message.queue == kOwnQueue ||
          response.queued_frames <= assumptions.queues[message.queue].length);
}

std::uint64_t utilisation_ppm(const Assumptions& assumptions, std::span<const Message> messages) {
  __extension__ using Wide = unsigned __int128;
  constexpr std::uint64_t whole = 1'000'000;
  constexpr std::uint64_t finer = 1'000'000;  // each term is rounded up so much finer than the sum
  Wide sum = 0;
  for (const Message& m : messages)
    if (has_load(assumptions, m))
      sum += (Wide{m.transmission} * whole * finer + m.period - 1) / m.period;
  return static_cast<std::uint64_t>((sum + finer - 1) / finer) + assumptions.background;
}

}  // namespace mlcca::core::can
