// SPDX-License-Identifier: BSD-2-Clause
#include "tests/core/bus_simulation/simulator.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <utility>

namespace mlcca::testing::bus {
namespace {

constexpr Time kFar = std::numeric_limits<Time>::max();
constexpr std::size_t kUnadmitted = ~std::size_t{0};
constexpr unsigned kErrorBits = 31;

struct Frame {
  std::size_t message = 0;
  Time release = 0;
  bool last = false;  ///< of its event
};

/// A first-in first-out that never gives memory back.
template <class T>
class Fifo {
 public:
  void push(const T& value) { values_.push_back(value); }
  void pop() {
    if (++head_ == values_.size()) clear();
  }
  void clear() {
    values_.clear();
    head_ = 0;
  }
  [[nodiscard]] const T& front() const { return values_[head_]; }
  [[nodiscard]] bool empty() const { return head_ == values_.size(); }
  [[nodiscard]] std::size_t size() const { return values_.size() - head_; }

 private:
  std::vector<T> values_;
  std::size_t head_ = 0;
};

/// What a message sends, in the order of time.
struct Source {
  Time release = 0;    ///< of the event that is offered next
  Time offered = 0;    ///< when its last frames are
  Time earlier = 0;    ///< when its first ones are
  unsigned first = 0;  ///< frames of the first ones that are not offered yet
  unsigned rest = 0;   ///< frames of the event that are offered last
  Time until = 0;      ///< nothing is offered before what was offered already
};

/// A gateway's frames: those that wait, by band, and those in its controller.
struct Gateway {
  std::vector<Fifo<Frame>> bands;
  Fifo<Frame> controller;
  std::size_t waiting = 0;
};

class Bus {
 public:
  Bus(const can::Assumptions& assumptions, std::span<const can::Message> messages,
      std::span<const Plan> plans, const World& world, Random& random)
      : a_(assumptions),
        messages_(messages),
        plans_(plans),
        world_(world),
        random_(random),
        sources_(messages.size()),
        own_(messages.size()),
        gap_(messages.size(), false),
        turn_(messages.size()),
        band_(messages.size(), 0),
        gateways_(assumptions.queues.size()),
        bit_(can::bit_time(assumptions.timing)),
        longest_(can::longest_frame(assumptions.timing, false)) {
    seen_.response.assign(messages.size(), 0);
    seen_.most_queued.assign(assumptions.queues.size(), 0);
    make_bands();
    for (std::size_t i = 0; i < messages.size(); ++i) {
      start(i);
      next_ = std::min(next_, arrival(i));
    }
    for (const can::Message& m : messages) longest_own_ = std::max(longest_own_, m.longest_frame);
  }

  Observed run() {
    Time now = 0;
    while (seen_.frames + seen_.errors < world_.most_frames) {
      take_arrivals(now);
      if (!is_anything_offered(now) && !has_unadmitted(now)) {
        const Time next = std::min(next_, next_turn());
        if (next == kFar || (pending_ == 0 && now > world_.idle_after)) break;
        now = std::max(now, world_.unadmitted ? std::min(next, world_.unadmitted_from) : next);
        continue;
      }
      // A frame that comes within a bit of the start still takes part in the arbitration.
      take_arrivals(now + bit_ - 1);
      now = send(arbitrate(now), now);
    }
    return std::move(seen_);
  }

 private:
  static constexpr std::size_t kNoSender = ~std::size_t{0} - 1;
  static constexpr std::size_t kGateways = 1U << 16U;  // offers from here on are of gateways

  /// The bands of a priority queue: one for each priority while there are enough.
  void make_bands() {
    for (std::size_t q = 0; q < gateways_.size(); ++q) {
      const can::Queue& queue = a_.queues[q];
      std::vector<std::uint32_t> priorities;
      for (const can::Message& m : messages_)
        if (m.queue == q) priorities.push_back(m.priority);
      std::ranges::sort(priorities);
      priorities.erase(std::unique(priorities.begin(), priorities.end()), priorities.end());
      const unsigned bands = queue.queueing == core::Queueing::fifo ? 1 : std::max(queue.bands, 1U);
      gateways_[q].bands.resize(bands);
      for (std::size_t i = 0; i < messages_.size(); ++i) {
        if (messages_[i].queue != q) continue;
        const auto at = std::ranges::find(priorities, messages_[i].priority) - priorities.begin();
        band_[i] = std::min(static_cast<unsigned>(at), bands - 1);
      }
    }
  }

  // --- arrivals
  // -----------------------------------------------------------------------------------

  [[nodiscard]] Time arrival(std::size_t i) const {
    const Source& s = sources_[i];
    return s.first > 0 ? s.earlier : s.offered;
  }
  void start(std::size_t i) {
    const can::Message& m = messages_[i];
    Source& s = sources_[i];
    switch (plans_[i].phases) {
      case Phases::random:
        s.release = random_.below(m.period);
        break;
      case Phases::together:
        s.release = plans_[i].first - std::min(m.jitter, plans_[i].first);
        s.until = plans_[i].first;
        break;
      case Phases::never:
        s.offered = kFar;
        return;
    }
    offer(i);
  }
  /// The frames of the event that is released at s.release.
  void offer(std::size_t i) {
    const can::Message& m = messages_[i];
    Source& s = sources_[i];
    const bool dense = plans_[i].phases == Phases::together;
    Time late = 0;
    if (!dense && m.jitter > 0) late = random_.one_in(2) ? m.jitter : random_.below(m.jitter + 1);
    s.offered = std::max(s.release + late, s.until);
    s.rest = m.frames;
    s.first = 0;
    // A gateway may get the frames of an event one by one; a node has all of them at once.
    const Time earliest = std::max(s.release, s.until);
    if (!dense && m.queue != can::kOwnQueue && m.frames > 1 && s.offered > earliest) {
      s.first = static_cast<unsigned>(random_.below(m.frames));
      s.rest -= s.first;
      s.earlier = random_.between(earliest, s.offered);
    }
    s.until = s.offered;
  }
  void take(std::size_t i) {
    Source& s = sources_[i];
    const bool first = s.first > 0;
    const unsigned frames = first ? std::exchange(s.first, 0) : s.rest;
    for (unsigned n = 0; n < frames; ++n)
      put({.message = i, .release = s.release, .last = !first && n + 1 == frames});
    if (first) return;
    const can::Message& m = messages_[i];
    s.release += m.period;
    if (plans_[i].phases == Phases::random && random_.one_in(4))
      s.release += random_.below(m.period);
    offer(i);
  }
  void put(const Frame& frame) {
    ++pending_;
    const std::uint32_t q = messages_[frame.message].queue;
    if (q == can::kOwnQueue) {
      own_[frame.message].push(frame);
      return;
    }
    Gateway& gateway = gateways_[q];
    gateway.bands[band_[frame.message]].push(frame);
    ++gateway.waiting;
    refill(q);
    const auto queued = static_cast<std::uint32_t>(gateway.waiting + gateway.controller.size());
    seen_.most_queued[q] = std::max(seen_.most_queued[q], queued);
  }
  void refill(std::size_t q) {
    Gateway& gateway = gateways_[q];
    while (gateway.waiting > 0 && gateway.controller.size() < a_.queues[q].fifo_depth) {
      auto& band = *std::ranges::find(gateway.bands, false, &Fifo<Frame>::empty);
      gateway.controller.push(band.front());
      band.pop();
      --gateway.waiting;
    }
  }
  void take_arrivals(Time until) {
    while (next_ <= until) {
      // Of those at one moment, the victim's come last.
      std::size_t earliest = kNoSender;
      for (std::size_t i = 0; i < messages_.size(); ++i) {
        if (arrival(i) != next_) continue;
        if (earliest == kNoSender || earliest == world_.victim) earliest = i;
      }
      take(earliest);
      next_ = kFar;
      for (std::size_t i = 0; i < messages_.size(); ++i) next_ = std::min(next_, arrival(i));
    }
  }

  [[nodiscard]] bool has_unadmitted(Time now) const {
    return world_.unadmitted && now >= world_.unadmitted_from;
  }

  // --- senders that pause, and send one event after the other
  // -------------------------------------

  struct Turn {
    std::size_t message = kNoSender;  ///< whose event is being sent
    Time from = 0;                    ///< the next frame is not offered before
  };
  /// Of a sender: kept with its first message.
  [[nodiscard]] std::size_t first_of_sender(std::size_t i) const {
    if (messages_[i].sender == can::kNoSender) return i;
    std::size_t first = 0;
    while (messages_[first].sender != messages_[i].sender) ++first;
    return first;
  }
  [[nodiscard]] bool pauses(std::size_t i) const { return messages_[i].pauses > 0; }
  [[nodiscard]] bool is_in_turn(std::size_t i, Time now) const {
    const Turn& turn = turn_[first_of_sender(i)];
    return turn.from <= now && (turn.message == i || turn.message == kNoSender);
  }
  /// The victim's event waits for all others of its sender.
  [[nodiscard]] bool gives_way(std::size_t i) const {
    if (i != world_.victim || turn_[first_of_sender(i)].message == i) return false;
    for (std::size_t k = 0; k < messages_.size(); ++k)
      if (k != i && !own_[k].empty() && first_of_sender(k) == first_of_sender(i)) return true;
    return false;
  }
  [[nodiscard]] bool is_offered(std::size_t i, Time now) const {
    if (own_[i].empty()) return false;
    return !pauses(i) || (is_in_turn(i, now + bit_ - 1) && !gives_way(i));
  }
  [[nodiscard]] bool is_anything_offered(Time now) const {
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (is_offered(i, now)) return true;
    return std::ranges::any_of(gateways_, [](const Gateway& g) { return !g.controller.empty(); });
  }
  [[nodiscard]] Time next_turn() const {
    Time next = kFar;
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (!own_[i].empty() && pauses(i)) {
        const Turn& turn = turn_[first_of_sender(i)];
        if (turn.message == i || turn.message == kNoSender) next = std::min(next, turn.from);
      }
    return next;
  }
  void pause_after(const Frame& frame, Time end) {
    const can::Message& m = messages_[frame.message];
    const Time longest = m.pauses / std::max(m.frames - 1, 1U);
    const Time pause = random_.one_in(4) ? random_.below(longest + 1) : longest;
    turn_[first_of_sender(frame.message)] = {.message = frame.last ? kNoSender : frame.message,
                                             .from = frame.last ? end : end + pause};
  }

  // --- the bus
  // ------------------------------------------------------------------------------------

  /// Who wins: a message, a gateway (from kGateways on), kUnadmitted or kNoSender.
  std::size_t arbitrate(Time now) {
    std::size_t winner = has_unadmitted(now) ? kUnadmitted : kNoSender;
    std::uint64_t best = std::numeric_limits<std::uint64_t>::max();
    const auto bid = [&](std::size_t who, std::size_t message) {
      // Equal priorities: the victim is the unlucky one, of others anyone.
      const std::uint64_t value = std::uint64_t{messages_[message].priority} * 4 +
                                  (message == world_.victim ? 3 : random_.below(3));
      if (value >= best) return;
      best = value;
      winner = who;
    };
    for (std::size_t i = 0; i < own_.size(); ++i) {
      if (is_offered(i, now) && !gap_[i]) bid(i, i);
      gap_[i] = false;
    }
    for (std::size_t q = 0; q < gateways_.size(); ++q)
      if (!gateways_[q].controller.empty())
        bid(kGateways + q, gateways_[q].controller.front().message);
    if (winner != kNoSender) return winner;
    // On an idle bus who was late for one arbitration starts the next.
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (is_offered(i, now)) bid(i, i);
    return winner;
  }

  /// Returns when the bus is free again.
  Time send(std::size_t who, Time now) {
    if (who == kUnadmitted) {
      take_arrivals(now + longest_ - 1);
      ++seen_.frames;
      return now + longest_;
    }
    const bool gateway = who >= kGateways;
    auto& queue = gateway ? gateways_[who - kGateways].controller : own_[who];
    const Frame frame = queue.front();
    const can::Message& m = messages_[frame.message];
    const Time length = frame.last ? m.last_frame : m.longest_frame;
    const Time end = now + length;
    take_arrivals(end - 1);  // what came meanwhile may be handed to the controller next
    if (is_hit(length, end - 1)) {
      ++seen_.errors;
      return end + kErrorBits * bit_;
    }
    ++seen_.frames;
    --pending_;
    queue.pop();
    if (gateway)
      refill(who - kGateways);
    else if (pauses(who))
      pause_after(frame, end);
    else
      gap_[who] = world_.one_at_a_time && m.frames > 1 && !m.back_to_back;
    if (frame.last) {
      Time& longest = seen_.response[frame.message];
      longest = std::max(longest, end - frame.release);
    }
    return end;
  }

  /// At most `count` errors in any interval.
  bool is_hit(Time length, Time at) {
    const core::FaultHypothesis& faults = a_.faults;
    if (faults.count == 0 || world_.errors == Errors::none) return false;
    if (world_.errors == Errors::longest && length < longest_own_) return false;
    if (world_.errors == Errors::random && !random_.one_in(3)) return false;
    while (!errors_.empty() && errors_.front() + faults.interval <= at) errors_.pop();
    if (errors_.size() >= faults.count) return false;
    errors_.push(at);
    return true;
  }

  const can::Assumptions& a_;
  std::span<const can::Message> messages_;
  std::span<const Plan> plans_;
  const World& world_;
  Random& random_;
  std::vector<Source> sources_;
  std::vector<Fifo<Frame>> own_;
  std::vector<bool> gap_;  ///< the next frame comes too late for the next arbitration
  std::vector<Turn> turn_;
  std::vector<unsigned> band_;
  std::vector<Gateway> gateways_;
  Fifo<Time> errors_;
  std::size_t pending_ = 0;  ///< frames
  Time next_ = kFar;         ///< arrival
  Time bit_;
  Time longest_;
  Time longest_own_ = 0;
  Observed seen_;
};

}  // namespace

Observed run(const can::Assumptions& assumptions, std::span<const can::Message> messages,
             std::span<const Plan> plans, const World& world, Random& random) {
  return Bus(assumptions, messages, plans, world, random).run();
}

}  // namespace mlcca::testing::bus
