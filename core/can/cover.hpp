// SPDX-License-Identifier: BSD-2-Clause
// Compares two messages of one sender that are promised for different reasons.
#pragma once
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Whether a sender that is promised `promised` may send `wanted` instead: that disturbs nobody
/// more and requires no shorter delay. Keys are ignored.
[[nodiscard]] bool covers(const Message& promised, const Message& wanted);

/// A message that covers both: it disturbs others as much as either and has the shorter of the two
/// delays. Key and queue are those of `a`.
[[nodiscard]] Message strictest(const Message& a, const Message& b);

}  // namespace mlcca::core::can
