// SPDX-License-Identifier: BSD-2-Clause
// Converts described publishers and networks into the input of the CAN analysis.
#pragma once
#include <cstddef>
#include <optional>

#include "core/can/message.hpp"
#include "core/model/system.hpp"

namespace mlcca::core::can {

/// The message that a publisher's events form on a CAN network, in an attribute set of its channel.
/// It fills in priority, frames, times, period and the jitter of the source; the caller adds key,
/// deadline, queue and the jitter of the route so far. Nullopt without a Period, without a binding
/// or node number there, without a bound of the payload, or without a bit rate (also that of the
/// data phase, if frames have one). The network's bindings must be sorted.
///
/// The identifier is that of core/profiles/profile.hpp. Where the description leaves a part of it
/// open, the message interferes with others at the highest priority and is analysed at the lowest.
/// If the size is not stated, an event counts as one longest frame of its binding. Longer events
/// are fragmented, see core/model/medium.hpp. If fragments have identifiers of their own (a
/// transport protocol), the message has pauses between them, and its node sends one event at a
/// time.
[[nodiscard]] std::optional<Message> message_of(const System& system, const Publisher& publisher,
                                                std::size_t set, std::size_t network,
                                                const Timing& timing);

/// The range of identifiers of a publisher's frames. Nullopt if the publisher lacks the node number
/// that the profile needs. `fragmented`: an event takes several frames.
struct Identifier {
  std::uint32_t id = 0;    ///< 11 or 29 bits
  std::uint32_t last = 0;  ///< `id` with ones in all bits that are left open
  bool extended = false;
};
[[nodiscard]] std::optional<Identifier> identifier_of(const Publisher& publisher,
                                                      const Network& network,
                                                      const Binding& binding, bool fragmented);

/// The described bit rates of a network.
[[nodiscard]] Timing timing_of(const Network& network);

/// The described assumptions of a CAN bus, with one queue for each gateway port on it, in the order
/// of System::gateways. `timing` may be the described one or that of the interface.
[[nodiscard]] Assumptions assumptions_of(const System& system, std::size_t network,
                                         const Timing& timing);

}  // namespace mlcca::core::can
