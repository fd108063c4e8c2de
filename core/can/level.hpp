// SPDX-License-Identifier: BSD-2-Clause
// The response time of one message, given the messages of higher or equal priority: its busy
// period, and the overhead that takes bus time beside messages. docs/explanation/can-analysis.md
// ("One message") derives the formulas.
#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/can/analysis.hpp"
#include "core/can/interference.hpp"
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Why a message cannot be analysed on its bus: which of its numbers, or of the bus, is out of
/// range.
enum class Unusable : std::uint8_t { no, bit_rate, period, frames, transmission, jitter, queue };

/// Checks a message. If one message of a bus is unusable, no message of that bus is bounded; if
/// only its jitter is too long, those are not bounded that it may win arbitration against.
[[nodiscard]] Unusable unusable(const Assumptions& assumptions, const Message& message);
[[nodiscard]] inline bool usable(const Assumptions& assumptions, const Message& message) {
  return unusable(assumptions, message) == Unusable::no;
}

/// The lowest priority (largest number) that a frame of the message has.
[[nodiscard]] inline std::uint32_t lowest_of(const Message& m) {
  return std::max(m.priority, m.lowest_priority);
}

/// Whether the message's effect on others depends on its own response, because its frames are
/// offered later than they are queued (fragments one at a time, shared queues), or whether its
/// frames have different priorities. Then all messages of the bus must be analysed together.
[[nodiscard]] bool is_coupled(const Message& message);

/// The bus time that other things than messages take: errors, background load and frames of unknown
/// senders.
class Overhead {
 public:
  explicit Overhead(const Assumptions& assumptions);

  /// The blocking by a lower-priority frame of at most `known` ns. With unknown senders it is at
  /// least the longest frame of the bus, with errors at least an error frame.
  [[nodiscard]] Time blocking(Time known) const { return std::max(known, least_blocking_); }

  /// The overhead (ns) until a last frame ends: background until it starts at `start`, errors until
  /// it ends at `end`. Each error spoils a frame of at most `longest` ns.
  [[nodiscard]] Time until(Time start, Time end, Time longest) const {
    return plain_ ? 0 : background(start) + errors(end, longest);
  }
  /// The share of the bus time that errors and background take.
  [[nodiscard]] Share share(Time longest) const;
  /// Whether there is neither background nor errors; then until() and share() are 0.
  [[nodiscard]] bool none() const { return plain_; }

 private:
  [[nodiscard]] Time background(Time t) const;
  [[nodiscard]] Time errors(Time t, Time longest) const;

  bool plain_;
  Time least_blocking_ = 0;
  Time longest_;      ///< ns, longest frame that is possible on the bus
  Time error_frame_;  ///< ns: error flags, delimiter, intermission
  std::uint32_t background_;
  FaultHypothesis faults_;
};

/// Whether the sender offers each frame only after the one before was sent, within and between
/// events. Then every frame is blocked once.
[[nodiscard]] inline bool one_at_a_time(const Message& m) {
  return m.queue == kOwnQueue && m.frames > 1 && !m.back_to_back;
}

/// The lower-priority messages that may block one whose frames are blocked one by one. Together
/// they cannot block for longer than what they send.
class Blockers {
 public:
  /// Adds a blocker. `response`: a bound of its response time, which must be bounded (not kNever).
  void add(const Message& message, Time response) {
    all_.push_back({std::min(message.period, kLongestTime), message.transmission, response});
    share_ += share_of(message.transmission, std::min(message.period, kLongestTime));
  }
  /// The time (ns) that the blockers take from the start of a busy period to `t`: sum of ceil((t +
  /// R) / T) C, for what was queued before the start and what comes later.
  [[nodiscard]] Time until(Time t) const {
    Time sum = 0;
    for (const Blocker& b : all_) sum += (t + b.response + b.period - 1) / b.period * b.cost;
    return sum;
  }
  [[nodiscard]] Share share() const { return share_; }

 private:
  struct Blocker {
    Time period;
    Time cost;
    Time response;
  };
  std::vector<Blocker> all_;
  Share share_ = 0;
};

/// The place of a message among the streams of an Interference: all before `end`, including itself,
/// have higher or equal priority.
struct Level {
  std::size_t self = 0;
  std::size_t end = 0;
  Time blocking = 0;  ///< ns, from Overhead::blocking()
  Time longest = 0;   ///< ns, longest frame of the streams before `end`; used only with overhead
  const Blockers* blockers = nullptr;  ///< all that may block, null if that is unknown
};

/// The result of level_response(); `response` (ns, from the nominal release) only counts if
/// `bounded`.
struct LevelResponse {
  bool bounded = false;
  Time response = 0;
  Time first = 0;  ///< ns, start of the last frame of the first event: a lower bound for the next
                   ///< analysis
};

/// Computes the response time of a message with a queue of its own. `begin` is 0 or a lower bound
/// of the start of the first event's last frame, such as LevelResponse::first of a former analysis
/// with fewer others.
[[nodiscard]] LevelResponse level_response(const Interference& all, const Overhead& overhead,
                                           const Message& message, const Level& level, Time begin);

/// A cheap sufficient test of the deadline: if it returns false, the message may still be in time.
/// Only valid if Overhead::none().
[[nodiscard]] bool surely_in_time(const Interference& all, const Message& message,
                                  const Level& level);

/// The smallest fixpoint of the monotone function `next` that is not below `begin`, which must not
/// exceed it. Nullopt if it exceeds kLongestTime or is not reached within kMaxSteps.
template <class Next>
[[nodiscard]] std::optional<Time> fixpoint(Time begin, const Next& next) {
  Time now = begin;
  for (unsigned step = 0; step < kMaxSteps; ++step) {
    const Time then = next(now);
    if (then <= now) return now;
    if (then > kLongestTime) return std::nullopt;
    now = then;
  }
  return std::nullopt;
}

}  // namespace mlcca::core::can
