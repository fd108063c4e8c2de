// SPDX-License-Identifier: BSD-2-Clause
// One message against those of higher or equal priority: the busy period of its level, and what
// takes bus time beside messages.
#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/can/analysis.hpp"
#include "core/can/interference.hpp"
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// What is wrong with the numbers of a message, or with those of its bus.
enum class Unusable : std::uint8_t { no, bit_rate, period, frames, transmission, jitter, queue };

/// Whether a message's numbers can be analysed at all on this bus. One that can't leaves no message
/// of its bus bounded; one with too much jitter none that it may win against.
[[nodiscard]] Unusable unusable(const Assumptions& assumptions, const Message& message);
[[nodiscard]] inline bool usable(const Assumptions& assumptions, const Message& message) {
  return unusable(assumptions, message) == Unusable::no;
}

/// The priority that no frame of the message is below.
[[nodiscard]] inline std::uint32_t lowest_of(const Message& m) {
  return std::max(m.priority, m.lowest_priority);
}

/// Whether the message needs the analysis of the whole bus: its frames are offered later than
/// queued for another reason than the bus, so that its effect on others depends on its own
/// response; or not all of them have one priority.
[[nodiscard]] bool is_coupled(const Message& message);

/// Errors, background and unknown senders.
class Overhead {
 public:
  explicit Overhead(const Assumptions& assumptions);

  /// What a frame of at most `known` ns that has lower priority can block; with unknown senders the
  /// longest frame of the bus, with errors at least one error frame.
  [[nodiscard]] Time blocking(Time known) const { return std::max(known, least_blocking_); }

  /// Time that background takes until a last frame starts at `start`, and errors until it ends at
  /// `end`, each of which spoils a frame of at most `longest`.
  [[nodiscard]] Time until(Time start, Time end, Time longest) const {
    return plain_ ? 0 : background(start) + errors(end, longest);
  }
  /// Bus share of both. `longest` as above.
  [[nodiscard]] Share share(Time longest) const;
  [[nodiscard]] bool none() const { return plain_; }

 private:
  [[nodiscard]] Time background(Time t) const;
  [[nodiscard]] Time errors(Time t, Time longest) const;

  bool plain_;
  Time least_blocking_ = 0;
  Time longest_;      ///< frame of the bus
  Time error_frame_;  ///< error flags, delimiter, intermission
  std::uint32_t background_;
  FaultHypothesis faults_;
};

/// Whether the sender offers a frame only after the one before it was sent, of the same event or of
/// the one before: then each frame is blocked once more.
[[nodiscard]] inline bool one_at_a_time(const Message& m) {
  return m.queue == kOwnQueue && m.frames > 1 && !m.back_to_back;
}

/// All frames that may block a message: a message that is blocked before each of its frames is
/// blocked by each of these once.
class Blockers {
 public:
  /// `response`: a bound from nominal release to the end of the last frame, not kNever.
  void add(const Message& message, Time response) {
    all_.push_back({std::min(message.period, kLongestTime), message.transmission, response});
    share_ += share_of(message.transmission, std::min(message.period, kLongestTime));
  }
  /// What these take from the start of a busy period until then: whatever was queued before and is
  /// not sent at that start, and what comes later.
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

/// Where a message stands among the streams of an Interference: those before `end`, itself
/// included, have higher or equal priority.
struct Level {
  std::size_t self = 0;
  std::size_t end = 0;
  Time blocking = 0;                   ///< from Overhead::blocking()
  Time longest = 0;                    ///< frame of those before `end`, needed if there is overhead
  const Blockers* blockers = nullptr;  ///< all that is behind `blocking`, if that is known
};

struct LevelResponse {
  bool bounded = false;
  Time response = 0;
  Time first = 0;  ///< when the last frame of the first event starts: where to begin next time
};

/// The response of a message with a queue of its own. `begin`: 0 or a start of the first event's
/// last frame that is known not to be too late.
[[nodiscard]] LevelResponse level_response(const Interference& all, const Overhead& overhead,
                                           const Message& message, const Level& level, Time begin);

/// Whether a bound shows that the deadline is met. Cheap and sufficient: a message that it does not
/// show may still be in time. Only without overhead.
[[nodiscard]] bool surely_in_time(const Interference& all, const Message& message,
                                  const Level& level);

/// Smallest value that `next` leaves as it is, from `begin`, which is not above it; `next` never
/// falls. Nothing if that exceeds kLongestTime, or is not reached within kMaxSteps.
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
