// SPDX-License-Identifier: BSD-2-Clause
// Messages whose sender pauses between the frames of an event, and sends one event after the other.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/can/interference.hpp"
#include "core/can/level.hpp"
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Messages of the same sender in the same queue, itself included; alone: it has no sender.
[[nodiscard]] std::vector<std::size_t> of_same_sender(std::span<const Message> messages,
                                                      std::size_t message);

/// The frames of another sender have the same address: receivers would take the one's for the
/// other's.
[[nodiscard]] bool shares_address(std::span<const Message> messages, std::size_t message);

/// Longest time for which the sender has something to send or pauses, from when it was idle, frames
/// of equal or higher priority that wait then included: nothing waits longer. `members`: all that
/// it sends, in a queue of its own, indices into `all`, rising. `level`: of the lowest priority of
/// their frames. Nothing: not bounded.
[[nodiscard]] std::optional<Time> busy_time(const Interference& all, const Overhead& overhead,
                                            std::span<const Message> messages,
                                            std::span<const std::size_t> members,
                                            const Level& level);

/// The same where a gateway sends, whose frames wait in a queue and whose pauses do not: until the
/// last frame is in the queue.
[[nodiscard]] std::optional<Time> pausing_time(std::span<const Message> messages,
                                               std::span<const std::size_t> members);

}  // namespace mlcca::core::can
