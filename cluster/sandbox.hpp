// SPDX-License-Identifier: BSD-2-Clause
// The sandbox of mlcca-cluster, entered before it communicates.
#pragma once
#include "base/result.hpp"

namespace mlcca::cluster {

/// Gives up for good: capabilities, gaining privileges, memory above 512 MiB, processes, writing to
/// files, and every system call that sockets, reading a certificate and name resolution do not need
/// (those fail with EPERM). Names are resolved by a thread of libcurl, in /etc/hosts and by DNS.
Result<void> enter_sandbox();

}  // namespace mlcca::cluster
