// SPDX-License-Identifier: BSD-2-Clause
// The types (BTF) of our programs. libbpf takes them for optional: when the kernel does not take
// them once, it loads the programs without. The verifier no longer verifies their global functions
// each by itself then, and walks through the gates for minutes.
#pragma once
#include "base/result.hpp"

struct bpf_map;

namespace mlcca::enforce {

/// From now on, a program of ours (a tc or XDP program that libbpf opens after this) is loaded only
/// if the kernel has its types; else the load fails before the verifier runs, with the error of the
/// call that failed, or with EAGAIN.
Result<void> demand_types();

/// libbpf asks the kernel once for what it can do, and keeps for the life of the process what a
/// failed call made of it. Of a map and a program that are loaded: whether it asked without a
/// failure. A process that got an error here cannot load a gate any more: a new one can.
Result<void> probed_without_failure(const bpf_map* memory, int program_fd);

}  // namespace mlcca::enforce
