// SPDX-License-Identifier: BSD-2-Clause
// Two messages of one sender that are promised for different reasons: which one covers the other,
// and the one that covers both.
#pragma once
#include "core/can/message.hpp"

namespace mlcca::core::can {

/// Whoever is promised `promised` may send `wanted`: it disturbs nobody more, and is not to be
/// there sooner. Their keys do not count.
[[nodiscard]] bool covers(const Message& promised, const Message& wanted);

/// Disturbs others as much as either of the two, and is to be there as soon as either: it covers
/// both. Key and queue are those of the first.
[[nodiscard]] Message strictest(const Message& a, const Message& b);

}  // namespace mlcca::core::can
