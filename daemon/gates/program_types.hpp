// SPDX-License-Identifier: BSD-2-Clause
// The type information (BTF) of our programs. libbpf treats it as optional: if the kernel refuses
// it once, libbpf loads the programs without it. The verifier then does not verify their global
// functions separately, and takes minutes for a gate.
#pragma once
#include "base/result.hpp"

struct bpf_map;

namespace mlcca::gates {

/// From now on, a tc or XDP program that libbpf opens is loaded only with its types. Otherwise the
/// load fails before the verifier runs, with the error of the failed call or with EAGAIN.
Result<void> demand_types();

/// libbpf probes the features of the kernel once, and keeps a wrong result for the life of the
/// process if a call fails. Checks, by a map and a program that were loaded, that it has probed
/// without a failure. After an error this process cannot load gates any more; a new one can.
Result<void> probed_without_failure(const bpf_map* memory, int program_fd);

}  // namespace mlcca::gates
