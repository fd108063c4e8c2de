// SPDX-License-Identifier: BSD-2-Clause
// Waits until no CPU runs a BPF program that began before.
#pragma once
#include "base/result.hpp"

namespace mlcca::enforce {

/// One RCU grace period, some 10 ms.
Result<void> wait_for_grace_period();

namespace detail {
/// The two ways to it, for tests: membarrier() refuses on kernels with nohz_full CPUs.
Result<void> wait_by_membarrier();
Result<void> wait_by_map_of_maps();
}  // namespace detail

}  // namespace mlcca::enforce
