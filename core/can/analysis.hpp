// SPDX-License-Identifier: BSD-2-Clause
// Response times of all messages of a CAN bus. docs/explanation/can-analysis.md derives what is
// computed here and names the sources and the preconditions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Longest period, jitter, transmission or response that is analysed, ns (about 18 minutes).
inline constexpr Time kLongestTime = Time{1} << 40U;
/// Most events of one message in one busy period that are analysed; a message with more of them is
/// not bounded.
inline constexpr std::uint64_t kMaxInstances = 4096;
/// Most steps towards one fixpoint, and most rounds over a bus whose messages depend on each other
/// in a circle; without a fixpoint by then a message is not bounded.
inline constexpr unsigned kMaxSteps = 100'000;
inline constexpr unsigned kMaxRounds = 1000;

struct Response {
  Time response = 0;     ///< ns, from the nominal release to the end of the last frame, at most
  bool bounded = false;  ///< otherwise `response` says nothing
  /// Most frames that wait in the message's queue at once, whoever sends them and those in the
  /// controller included; 0 with a queue of its own. Not bounded: the largest number there is.
  std::uint32_t queued_frames = 0;

  [[nodiscard]] bool meets(Time deadline) const { return bounded && response <= deadline; }
  bool operator==(const Response&) const = default;
};

/// Bounds for all messages, in their order. Exact (the bound is reached if frames are as long as
/// stated, phases are the worst and no fault or background is assumed) for messages with queues of
/// their own and distinct priorities, whose frames wait together; otherwise safe. Messages whose
/// queue does not exist, or with a period of 0, are not bounded.
[[nodiscard]] std::vector<Response> analyse(const Assumptions& assumptions,
                                            std::span<const Message> messages);

/// The same, from a state that is known to be too small or right: responses of the same messages
/// when there were fewer others. 0: nothing is known. It saves rounds, the result is the same.
[[nodiscard]] std::vector<Response> analyse_from(const Assumptions& assumptions,
                                                 std::span<const Message> messages,
                                                 std::span<const Time> at_least);

/// Whether the message's deadline is met and its queue, if it shares one, can hold what waits.
[[nodiscard]] bool fits(const Assumptions& assumptions, const Message& message,
                        const Response& response);

/// Share of the bus time that the messages and the background take, 1e-6, rounded up.
[[nodiscard]] std::uint64_t utilisation_ppm(const Assumptions& assumptions,
                                            std::span<const Message> messages);

/// The band of each message in the priority queue that it shares, 0 first; 0 for others. The
/// priorities of a queue have a band each while there are enough; all others share the last one.
/// Messages whose priorities overlap (Message::lowest_priority) share a band.
[[nodiscard]] std::vector<unsigned> bands_of(const Assumptions& assumptions,
                                             std::span<const Message> messages);

/// Indices of the messages, highest priority first, in an order in which all of them meet their
/// deadlines; nothing if there is no such order (Audsley, "On priority assignment in fixed priority
/// scheduling", Information Processing Letters 79, 2001). Their priorities are not used. For
/// messages with queues of their own the answer is exact. For others it is safe: an order that is
/// found was analysed with all queues and holds, but one may exist where none is found.
[[nodiscard]] std::optional<std::vector<std::size_t>> assign_priorities(
    const Assumptions& assumptions, std::span<const Message> messages);

}  // namespace mlcca::core::can
