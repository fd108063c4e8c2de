// SPDX-License-Identifier: BSD-2-Clause
// How an event travels on a medium: in how many frames, and how long each may be.
#pragma once
#include <cstdint>

#include "core/model/system.hpp"

namespace mlcca::core {

struct Fragmentation;

/// How the network carries events of the binding that are longer than one frame; null: not at all.
[[nodiscard]] const Fragmentation* fragmentation_of(const Network& network, const Binding& binding);

/// The same, where the frames have identifiers of their own, by which no gate knows the channel:
/// they are judged by what the first of them says.
[[nodiscard]] const Fragmentation* transport_of(const Network& network, const Binding* binding,
                                                Value bytes);

/// What a sender pauses at most between the frames of an event, all together, ns.
[[nodiscard]] Value pauses_of(const Network& network, const Binding* binding, Value bytes);

/// Payload bytes of the longest CAN frame of a format.
inline constexpr unsigned kClassicBytes = 8;
inline constexpr unsigned kFdBytes = 64;
inline constexpr unsigned kXlBytes = 2048;

/// Frames of an event, at most, and the largest event that FAMOUSO puts into them on classic CAN:
/// 4064 fragments of 6 bytes, the last 32 of 7.
inline constexpr unsigned kMaxFrames = 4096;
inline constexpr Value kFamousoMaxEvent = 24608;

/// Payload bytes of the longest datagram that FAMOUSO sends, and its largest event there.
inline constexpr unsigned kDatagramBytes = 8183;
inline constexpr Value kDatagramMaxEvent = 65535;

/// The longest event in a frame of IEEE 802.15.4, where FAMOUSO does not fragment. Of 127 octets a
/// header with an extended address takes 15 (to all of its own PAN), the check sequence 2, and the
/// subject 8.
inline constexpr unsigned kWpanBytes = 127 - 15 - 2 - 8;

/// Frames that an event of `bytes` takes on the network, at least 1. Some profiles fragment what is
/// longer than one frame: see Fragmentation.
[[nodiscard]] unsigned frames_per_event(const Network& network, const Binding* binding,
                                        Value bytes);

/// Whether an event of `bytes` is fragmented.
[[nodiscard]] bool is_fragmented(const Network& network, const Binding* binding, Value bytes);

/// Payload bytes of the longest frame that the binding allows.
[[nodiscard]] unsigned frame_bytes(const Binding& binding);

/// Payload bytes of the longest frame of an event of `bytes`, as it is on the bus: above 8 bytes an
/// FD frame has one of a few fixed sizes.
[[nodiscard]] unsigned frame_bytes(const Network& network, const Binding& binding, Value bytes);

/// The largest event that the network carries.
[[nodiscard]] Value event_bytes(const Network& network, const Binding& binding);

/// The same of a network that carries subjects, and the payload of its longest frame or datagram.
[[nodiscard]] Value event_bytes(const Network& network);
[[nodiscard]] unsigned datagram_bytes(const Network& network);

}  // namespace mlcca::core
