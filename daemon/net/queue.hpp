// SPDX-License-Identifier: BSD-2-Clause
// The queueing discipline of a CAN interface, by which the frame that wins arbitration leaves
// first.
#pragma once
#include "base/result.hpp"

namespace mlcca::net {

/// The bands of the discipline, as many as prio has.
inline constexpr int kQueueBands = 16;

/// Puts a prio discipline with one band for each skb->priority at the root of the interface, under
/// our own handle. True if it is already there, and unchanged. False: there was none or another
/// one, which was replaced.
[[nodiscard]] Result<bool> keep_priority_queue(int ifindex);

}  // namespace mlcca::net
