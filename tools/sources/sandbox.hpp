// SPDX-License-Identifier: BSD-2-Clause
// What a process gives up before it reads what untrusted peers write.
#pragma once
#include "base/result.hpp"

namespace mlcca::sources {

/// For good: capabilities, new privileges, descriptors above 2, memory above 256 MiB, processes,
/// writing to files, and every system call that reading a file or a local server does not take
/// (those fail with EPERM). The process is killed when the one that started it ends.
Result<void> enter_sandbox();

}  // namespace mlcca::sources
