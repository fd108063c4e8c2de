// SPDX-License-Identifier: BSD-2-Clause
// Described publishers as messages of a CAN bus.
#pragma once
#include <cstddef>
#include <optional>

#include "core/can/message.hpp"
#include "core/model/system.hpp"

namespace mlcca::core::can {

/// The messages that a publisher's events are on a CAN network, in an attribute set of its channel.
/// Priority, frames, times, period and the jitter of the source are filled in; key, deadline, queue
/// and the jitter of the way so far are the caller's. Nothing without a Period, without a binding
/// or identity on that network, when the payload is not bounded by anything, or when the bit rate
/// is unknown, or that of the data phase of frames that have one. The network's bindings must be
/// sorted.
///
/// The identifier is what core/profiles/profile.hpp says; where the description leaves a part of it
/// open, the message disturbs others with the first and suffers with the last of them. Where the
/// size is not stated, an event counts as one longest frame of its binding; a longer event is
/// fragmented as core/model/medium.hpp says. Where fragments have identifiers of their own, the
/// message has the pauses between them and is its node's, one event at a time.
[[nodiscard]] std::optional<Message> message_of(const System& system, const Publisher& publisher,
                                                std::size_t set, std::size_t network,
                                                const Timing& timing);

/// The identifiers of a publisher's frames: the first and the last that they may have. Nothing
/// where the publisher lacks the node that the profile needs. `fragmented`: an event takes several
/// frames.
struct Identifier {
  std::uint32_t id = 0;    ///< 11 or 29 bits
  std::uint32_t last = 0;  ///< what is left open are ones here
  bool extended = false;
};
[[nodiscard]] std::optional<Identifier> identifier_of(const Publisher& publisher,
                                                      const Network& network,
                                                      const Binding& binding, bool fragmented);

/// The bit rates that are described for a network.
[[nodiscard]] Timing timing_of(const Network& network);

/// What is described of a CAN bus, with one queue for each gateway port on it, in the order of
/// System::gateways. `timing` may come from the interface itself.
[[nodiscard]] Assumptions assumptions_of(const System& system, std::size_t network,
                                         const Timing& timing);

}  // namespace mlcca::core::can
