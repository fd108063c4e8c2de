// SPDX-License-Identifier: BSD-2-Clause
// How an event travels on a medium: in how many frames, and how long each may be.
#pragma once
#include <cstdint>

#include "core/system.hpp"

namespace mlcca::core {

/// Payload bytes of the longest CAN frame of a format.
inline constexpr unsigned kClassicBytes = 8;
inline constexpr unsigned kFdBytes = 64;

/// Largest event that FAMOUSO's fragmentation can carry on classic CAN (4096 fragments).
inline constexpr Value kFamousoMaxEvent = 24608;

/// Frames that an event of `bytes` takes on the network, at least 1. FAMOUSO splits what is longer
/// than one frame with a header of 1 byte (up to 32 fragments) or 2; other profiles do not split.
[[nodiscard]] unsigned frames_per_event(const Network& network, const Binding* binding,
                                        Value bytes);

/// Whether an event of `bytes` is split, so that frames carry the fragment bit.
[[nodiscard]] bool is_fragmented(const Network& network, const Binding* binding, Value bytes);

/// Payload bytes of the longest frame that the binding allows.
[[nodiscard]] unsigned frame_bytes(const Binding& binding);

}  // namespace mlcca::core
