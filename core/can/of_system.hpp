// SPDX-License-Identifier: BSD-2-Clause
// Described publishers as messages of a CAN bus.
#pragma once
#include <cstddef>
#include <optional>

#include "core/can/message.hpp"
#include "core/system.hpp"

namespace mlcca::core::can {

/// The messages that a publisher's events are on a CAN network, in an attribute set of its channel.
/// Priority, frames, times, period and the jitter of the source are filled in; key, deadline, queue
/// and the jitter of the way so far are the caller's. Nothing without a Period, without a binding
/// or identity on that network, when the payload is not bounded by anything, or when the bit rate
/// is unknown. The network's bindings must be sorted.
///
/// FAMOUSO: identifier of priority, node and etag; where the size is not stated, an event counts as
/// one longest frame of its binding; a longer event is split as core/medium.hpp says. Raw: a frame
/// is at most as long as its binding allows.
[[nodiscard]] std::optional<Message> message_of(const System& system, const Publisher& publisher,
                                                std::size_t set, std::size_t network,
                                                const Timing& timing);

/// The identifier of frames of a publisher that are not fragments. FAMOUSO: the publisher must have
/// a node.
struct Identifier {
  std::uint32_t id = 0;  ///< 11 or 29 bits
  bool extended = false;
};
[[nodiscard]] Identifier identifier_of(const Publisher& publisher, const Network& network,
                                       const Binding& binding);

/// The bit rates that are described for a network.
[[nodiscard]] Timing timing_of(const Network& network);

/// What is described of a CAN bus, with one queue for each gateway port on it, in the order of
/// System::gateways. `timing` may come from the interface itself.
[[nodiscard]] Assumptions assumptions_of(const System& system, std::size_t network,
                                         const Timing& timing);

}  // namespace mlcca::core::can
