// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <sys/socket.h>
#include <sys/types.h>

#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca {

/// A local socket of `type` (SOCK_STREAM, SOCK_SEQPACKET) that listens at `path`, in place of one
/// that a former process left behind. Does not block. `mode`: who may connect, where it is not as
/// the umask says; `backlog`: how many may wait to be accepted.
[[nodiscard]] Result<Fd> listen_at(const std::string& path, int type, mode_t mode = 0,
                                   int backlog = SOMAXCONN);

/// The one socket of `type` that systemd has made, listening and not blocking; -1: it has made
/// none.
[[nodiscard]] Result<Fd> handed_over(int type);

}  // namespace mlcca
