// SPDX-License-Identifier: BSD-2-Clause
// Computes response times for all messages of a CAN bus. docs/explanation/can-analysis.md derives
// the formulas and names sources and preconditions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can {

/// The longest period, jitter, transmission or response that is analysed, in ns (about 18 minutes).
inline constexpr Time kLongestTime = Time{1} << 40U;
/// The most events of one message in a busy period; a message with more is not bounded.
inline constexpr std::uint64_t kMaxInstances = 4096;
/// The most steps towards one fixpoint, and the most rounds over a bus whose bounds depend on each
/// other. A message without a fixpoint by then is not bounded.
inline constexpr unsigned kMaxSteps = 100'000;
inline constexpr unsigned kMaxRounds = 1000;

/// The result for one message.
struct Response {
  Time response = 0;     ///< ns, upper bound from the nominal release to the end of the last frame
  bool bounded = false;  ///< otherwise `response` is meaningless
  /// The most frames that wait at once in the message's queue, those of all senders and those in
  /// the controller included. 0 with a queue of its own; the largest number if not bounded.
  std::uint32_t queued_frames = 0;

  [[nodiscard]] bool meets(Time deadline) const { return bounded && response <= deadline; }
  bool operator==(const Response&) const = default;
};

/// Computes bounds for all messages, in their order. They are exact (reached with frames as long as
/// stated, worst-case phases and no faults or background) for messages with their own queues and
/// distinct priorities whose frames wait together; otherwise they are safe. A message whose queue
/// does not exist or whose period is 0 is not bounded.
[[nodiscard]] std::vector<Response> analyse(const Assumptions& assumptions,
                                            std::span<const Message> messages);

/// Like analyse(), but starts from known lower bounds of the responses, e.g. those of the same
/// messages among fewer others; 0 means nothing is known. The result is the same with fewer rounds.
[[nodiscard]] std::vector<Response> analyse_from(const Assumptions& assumptions,
                                                 std::span<const Message> messages,
                                                 std::span<const Time> at_least);

/// Whether the message meets its deadline and its shared queue, if any, holds all waiting frames.
[[nodiscard]] bool fits(const Assumptions& assumptions, const Message& message,
                        const Response& response);

/// The share of bus time that messages and background take, in 1e-6, rounded up.
[[nodiscard]] std::uint64_t utilisation_ppm(const Assumptions& assumptions,
                                            std::span<const Message> messages);

/// The band of each message in its priority queue, 0 first; 0 for messages without one. Each
/// priority of a queue has its own band while there are enough; the remaining ones share the last.
/// Messages whose priorities overlap (Message::lowest_priority) share a band.
[[nodiscard]] std::vector<unsigned> bands_of(const Assumptions& assumptions,
                                             std::span<const Message> messages);

/// Finds an order of priorities in which all messages meet their deadlines; returns their indices,
/// highest priority first, or nullopt if there is none (Audsley, "On priority assignment in fixed
/// priority scheduling", Information Processing Letters 79, 2001). Their present priorities are
/// ignored. Exact for messages with their own queues. With shared queues it is safe: a result has
/// been analysed completely, but an order may exist that is not found.
[[nodiscard]] std::optional<std::vector<std::size_t>> assign_priorities(
    const Assumptions& assumptions, std::span<const Message> messages);

}  // namespace mlcca::core::can
