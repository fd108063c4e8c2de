// SPDX-License-Identifier: BSD-2-Clause
// Messages of a sender that pauses between the frames of an event and sends one event after the
// other. See docs/explanation/can-analysis.md, "Senders that pause".
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/can/interference.hpp"
#include "core/can/level.hpp"
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Indices of the messages with the same sender and the same queue as this one, including it; only
/// itself if it has no sender.
[[nodiscard]] std::vector<std::size_t> of_same_sender(std::span<const Message> messages,
                                                      std::size_t message);

/// Whether another sender uses the same source address. Receivers then cannot distinguish the
/// frames of the two.
[[nodiscard]] bool shares_address(std::span<const Message> messages, std::size_t message);

/// The longest time (ns) from when the sender was idle until it is idle again. It includes pauses,
/// blocking and frames of equal or higher priority; no event of the sender waits longer. `members`:
/// ascending indices into `all` of all its messages, which have a queue of their own. `level`: the
/// level of the lowest priority of their frames. Nullopt if not bounded.
[[nodiscard]] std::optional<Time> busy_time(const Interference& all, const Overhead& overhead,
                                            std::span<const Message> messages,
                                            std::span<const std::size_t> members,
                                            const Level& level);

/// The same time for a gateway, whose pauses are timers that do not depend on its queue: the
/// longest time (ns) until the last frame has entered the queue. Nullopt if not bounded.
[[nodiscard]] std::optional<Time> pausing_time(std::span<const Message> messages,
                                               std::span<const std::size_t> members);

}  // namespace mlcca::core::can
