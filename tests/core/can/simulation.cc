// SPDX-License-Identifier: BSD-2-Clause
#include "tests/core/can/simulation.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <map>
#include <optional>

namespace mlcca::core::can::simulation {
namespace {

constexpr Time kFar = std::numeric_limits<Time>::max();

/// A frame on its way.
struct Frame {
  std::size_t event = 0;
  std::size_t message = 0;
  std::uint32_t number = 0;  ///< in its event
  Time queued = 0;
};

/// Who offers a frame. Unadmitted senders have no message.
struct Offer {
  enum class Who : std::uint8_t { message, queue, blocker, background };
  Who who = Who::message;
  std::size_t index = 0;
  std::uint64_t priority = 0;
  Time time = 0;  ///< on the bus
};

class Bus {
 public:
  Bus(const Assumptions& assumptions, std::span<const Message> messages,
      std::span<const unsigned> bands, std::span<const Event> events, const World& world,
      Random& random)
      : assumptions_(assumptions),
        messages_(messages),
        bands_(bands),
        events_(events),
        world_(world),
        random_(random),
        own_(messages.size()),
        waiting_(assumptions.queues.size()),
        controller_(assumptions.queues.size()),
        bit_(bit_time(assumptions.timing)),
        longest_(longest_frame(assumptions.timing, assumptions.fd_frames)) {
    observed_.response.assign(messages.size(), 0);
    observed_.most_queued.assign(assumptions.queues.size(), 0);
    for (std::size_t e = 0; e < events.size(); ++e)
      for (std::uint32_t n = 0; n < events[e].queued.size(); ++n)
        arrivals_.push_back({e, events[e].message, n, events[e].queued[n]});
    std::ranges::stable_sort(arrivals_, {}, &Frame::queued);
  }

  Observed run() {
    Time now = 0;
    while (true) {
      take_arrivals(now);
      if (!anything_offered(now)) {
        const Time next = next_arrival();
        if (next == kFar) return std::move(observed_);
        now = std::max(now, next);
        take_arrivals(now);
      }
      // A frame that comes within a bit of the start still takes part in the arbitration.
      take_arrivals(now + bit_ - 1);
      const auto winner = arbitrate(now);
      in_gap_.clear();
      if (!winner) continue;
      now = send(*winner, now);
    }
  }

 private:
  void take_arrivals(Time until) {
    for (; next_ < arrivals_.size() && arrivals_[next_].queued <= until; ++next_) {
      const Frame& f = arrivals_[next_];
      const Message& m = messages_[f.message];
      if (m.queue == kOwnQueue) {
        own_[f.message].push_back(f);
        continue;
      }
      waiting_[m.queue][bands_[f.message]].push_back(f);
      ++queued_[m.queue];
      observed_.most_queued[m.queue] = std::max(observed_.most_queued[m.queue], queued_[m.queue]);
      refill(m.queue);
    }
  }
  void refill(std::size_t q) {
    auto& bands = waiting_[q];
    while (controller_[q].size() < assumptions_.queues[q].fifo_depth && !bands.empty()) {
      auto& band = bands.begin()->second;
      controller_[q].push_back(band.front());
      band.pop_front();
      if (band.empty()) bands.erase(bands.begin());
    }
  }
  [[nodiscard]] Time next_arrival() const {
    return next_ < arrivals_.size() ? arrivals_[next_].queued : kFar;
  }
  [[nodiscard]] bool anything_offered(Time now) const {
    return std::ranges::any_of(own_, [](const auto& f) { return !f.empty(); }) ||
           std::ranges::any_of(controller_, [](const auto& f) { return !f.empty(); }) ||
           (now < world_.duration && (world_.late_blocker || background_due(now)));
  }
  [[nodiscard]] bool background_due(Time now) const {
    return assumptions_.background > 0 && background_next_ <= now;
  }
  [[nodiscard]] Time time_of(const Frame& f) const {
    const Message& m = messages_[f.message];
    return f.number + 1 == m.frames ? m.last_frame : m.longest_frame;
  }

  std::optional<Offer> arbitrate(Time now) {
    std::vector<Offer> offers;
    constexpr std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (!own_[i].empty() && !in_gap_.contains(i))
        offers.push_back({Offer::Who::message, i, std::uint64_t{messages_[i].priority} + 1,
                          time_of(own_[i].front())});
    for (std::size_t q = 0; q < controller_.size(); ++q)
      if (!controller_[q].empty()) {
        const Frame& f = controller_[q].front();
        offers.push_back(
            {Offer::Who::queue, q, std::uint64_t{messages_[f.message].priority} + 1, time_of(f)});
      }
    if (now < world_.duration && world_.late_blocker)
      offers.push_back({Offer::Who::blocker, 0, last, longest_});
    if (now < world_.duration && background_due(now))
      offers.push_back(
          {Offer::Who::background, 0, world_.background_wins ? 0 : last - 1, longest_});
    if (offers.empty()) return std::nullopt;
    // Equal priorities: anyone may be first.
    std::ranges::shuffle(offers, random_);
    return *std::ranges::min_element(offers, {}, &Offer::priority);
  }
  /// Returns when the bus is free again.
  Time send(const Offer& offer, Time now) {
    const Time end = now + offer.time;
    take_arrivals(end - 1);  // what came meanwhile may be handed to the controller next
    if (offer.who == Offer::Who::background) {
      // Not more than the load that is stated, wherever the measurement starts.
      const Time apart = longest_ * 1'000'000 / assumptions_.background + 1;
      background_next_ = now + apart;
    }
    if (hit(end - 1)) {
      ++observed_.errors;
      return end + 31 * bit_;
    }
    ++observed_.frames;
    if (offer.who == Offer::Who::message) {
      const Frame f = own_[offer.index].front();
      own_[offer.index].pop_front();
      finish(f, end);
      const Message& m = messages_[f.message];
      // The next fragment comes a moment too late for the next arbitration.
      if (!m.back_to_back && f.number + 1 < m.frames) in_gap_[f.message] = true;
    } else if (offer.who == Offer::Who::queue) {
      const Frame f = controller_[offer.index].front();
      controller_[offer.index].pop_front();
      --queued_[static_cast<std::uint32_t>(offer.index)];
      refill(offer.index);
      finish(f, end);
    }
    return end;
  }
  bool hit(Time at) {
    const FaultHypothesis& faults = assumptions_.faults;
    if (faults.count == 0 || world_.error_chance == 0) return false;
    while (!errors_.empty() && errors_.front() + faults.interval <= at) errors_.pop_front();
    if (errors_.size() >= faults.count) return false;
    if (random_() % 100 >= world_.error_chance) return false;
    errors_.push_back(at);
    return true;
  }
  void finish(const Frame& f, Time end) {
    if (f.number + 1 < messages_[f.message].frames) return;
    auto& longest = observed_.response[f.message];
    longest = std::max(longest, end - events_[f.event].release);
  }

  const Assumptions& assumptions_;
  std::span<const Message> messages_;
  std::span<const unsigned> bands_;
  std::span<const Event> events_;
  World world_;
  Random& random_;
  std::vector<Frame> arrivals_;
  std::size_t next_ = 0;
  std::vector<std::deque<Frame>> own_;
  std::vector<std::map<unsigned, std::deque<Frame>>> waiting_;  ///< of each queue, by band
  std::vector<std::deque<Frame>> controller_;
  std::map<std::uint32_t, std::uint32_t> queued_;
  std::map<std::size_t, bool> in_gap_;  ///< messages between two fragments
  std::deque<Time> errors_;
  Time background_next_ = 0;
  Time bit_;
  Time longest_;
  Observed observed_;
};

}  // namespace

std::vector<Event> random_events(std::span<const Message> messages, Time duration, Random& random) {
  std::vector<Event> events;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const Message& m = messages[i];
    Time release = random() % m.period;
    Time last_queued = 0;  // events of a message are queued in their order
    while (release < duration) {
      Event e{.message = i, .release = release, .queued = {}};
      for (std::uint32_t n = 0; n < m.frames; ++n) {
        Time late = random() % 2 == 0 ? m.jitter : random() % (m.jitter + 1);
        // A node has all frames of an event at once; a gateway may get them one by one.
        if (m.queue == kOwnQueue && n > 0) late = e.queued.front() - release;
        e.queued.push_back(std::max(release + late, last_queued));
      }
      std::ranges::sort(e.queued);
      last_queued = e.queued.back();
      events.push_back(std::move(e));
      release += m.period;
      if (random() % 4 == 0) release += random() % m.period;
    }
  }
  return events;
}

std::vector<Event> critical_events(std::span<const Message> messages, std::size_t victim,
                                   Time duration, Time bit) {
  Time instant = bit;
  std::size_t blocker = messages.size();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    instant = std::max(instant, messages[i].jitter + bit);
    if (messages[i].priority > messages[victim].priority &&
        (blocker == messages.size() || messages[i].longest_frame > messages[blocker].longest_frame))
      blocker = i;
  }
  std::vector<Event> events;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const Message& m = messages[i];
    const Time first = i == blocker ? instant - bit : instant;
    if (i != blocker && m.priority > messages[victim].priority) continue;
    for (Time release = first - m.jitter; release < duration; release += m.period)
      events.push_back({.message = i,
                        .release = release,
                        .queued = std::vector<Time>(m.frames, std::max(release, first))});
  }
  return events;
}

Observed run(const Assumptions& assumptions, std::span<const Message> messages,
             std::span<const unsigned> bands, std::span<const Event> events, const World& world,
             Random& random) {
  return Bus(assumptions, messages, bands, events, world, random).run();
}

}  // namespace mlcca::core::can::simulation
