// SPDX-License-Identifier: BSD-2-Clause
// What mlcca-cluster gives up before it speaks to anybody.
#pragma once
#include "base/result.hpp"

namespace mlcca::cluster {

/// For good: capabilities, new privileges, memory above 512 MiB, processes, writing to files, and
/// every system call that sockets, reading a certificate and looking up a name do not take (those
/// fail with EPERM). Names are looked up by a thread of libcurl, in /etc/hosts and by DNS.
Result<void> enter_sandbox();

}  // namespace mlcca::cluster
