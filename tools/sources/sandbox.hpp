// SPDX-License-Identifier: BSD-2-Clause
// The sandbox of mlcca-sources, entered before it reads what untrusted peers write.
#pragma once
#include "base/result.hpp"

namespace mlcca::sources {

/// Gives up for good: capabilities, gaining privileges, descriptors above 2, memory above 256 MiB,
/// processes, writing to files, and every system call that reading a file or a local server does
/// not need (those fail with EPERM). The process is killed when its parent ends.
Result<void> enter_sandbox();

}  // namespace mlcca::sources
