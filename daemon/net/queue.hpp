// SPDX-License-Identifier: BSD-2-Clause
// The queueing discipline of a CAN interface, so that the frame that wins arbitration leaves first.
#pragma once
#include "base/result.hpp"

namespace mlcca::net {

/// Bands of the discipline: as many as prio has.
inline constexpr int kQueueBands = 16;

/// Puts a prio discipline with one band for each skb->priority at the root of the interface, under
/// a handle of our own; leaves it alone when it is there. False: another one was there and has been
/// replaced, or there was none.
[[nodiscard]] Result<bool> keep_priority_queue(int ifindex);

}  // namespace mlcca::net
