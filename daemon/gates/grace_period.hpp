// SPDX-License-Identifier: BSD-2-Clause
// Waits until no CPU runs a BPF program that began before the call.
#pragma once
#include "base/result.hpp"

namespace mlcca::gates {

/// Waits for one RCU grace period, about 10 ms.
Result<void> wait_for_grace_period();

namespace detail {
/// The two ways to wait, for tests. membarrier() is refused on kernels with nohz_full CPUs.
Result<void> wait_by_membarrier();
Result<void> wait_by_map_of_maps();
}  // namespace detail

}  // namespace mlcca::gates
