// SPDX-License-Identifier: BSD-2-Clause
// How an event travels on a medium: the number of its frames, and the length of each.
#pragma once
#include <cstdint>

#include "core/model/system.hpp"

namespace mlcca::core {

struct Fragmentation;

/// How the network carries events of this binding that are longer than one frame; null if it
/// cannot.
[[nodiscard]] const Fragmentation* fragmentation_of(const Network& network, const Binding& binding);

/// Like fragmentation_of(), but only for transport protocols whose frames have identifiers of their
/// own (such as J1939 TP). A gate cannot derive their channel from the identifier and decides by
/// the announcement in the first frame. Null if events of `bytes` need no such protocol.
[[nodiscard]] const Fragmentation* transport_of(const Network& network, const Binding* binding,
                                                Value bytes);

/// The sum of the longest pauses that a sender may make between the frames of one event, in ns.
[[nodiscard]] Value pauses_of(const Network& network, const Binding* binding, Value bytes);

/// Payload bytes of the longest CAN frame of each format.
inline constexpr unsigned kClassicBytes = 8;
inline constexpr unsigned kFdBytes = 64;
inline constexpr unsigned kXlBytes = 2048;

/// The most frames of one event, and the largest event that FAMOUSO fragments on classic CAN: 4064
/// fragments of 6 bytes and the last 32 of 7.
inline constexpr unsigned kMaxFrames = 4096;
inline constexpr Value kFamousoMaxEvent = 24608;

/// Payload bytes of the longest datagram that FAMOUSO sends, and of its largest (fragmented) event
/// in datagrams.
inline constexpr unsigned kDatagramBytes = 8183;
inline constexpr Value kDatagramMaxEvent = 65535;

/// Payload bytes of the longest event in an IEEE 802.15.4 frame; FAMOUSO does not fragment there.
/// Of 127 octets the header with an extended address takes 15 (broadcast in its own PAN), the check
/// sequence 2 and the subject 8.
inline constexpr unsigned kWpanBytes = 127 - 15 - 2 - 8;

/// The number of frames that an event of `bytes` takes on the network, at least 1. `binding` may be
/// null on a network that carries subjects.
[[nodiscard]] unsigned frames_per_event(const Network& network, const Binding* binding,
                                        Value bytes);

/// Whether an event of `bytes` takes more than one frame.
[[nodiscard]] bool is_fragmented(const Network& network, const Binding* binding, Value bytes);

/// Payload bytes of the longest frame of the binding's format.
[[nodiscard]] unsigned frame_bytes(const Binding& binding);

/// Payload bytes of the longest frame of an event of `bytes`, padding included: above 8 bytes an FD
/// frame has one of a few fixed lengths.
[[nodiscard]] unsigned frame_bytes(const Network& network, const Binding& binding, Value bytes);

/// Payload bytes of the largest event that the binding can carry.
[[nodiscard]] Value event_bytes(const Network& network, const Binding& binding);

/// For networks that carry subjects: payload bytes of the largest event, and of the longest single
/// frame or datagram.
[[nodiscard]] Value event_bytes(const Network& network);
[[nodiscard]] unsigned datagram_bytes(const Network& network);

}  // namespace mlcca::core
