// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <sys/socket.h>
#include <sys/types.h>

#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca {

/// A local socket of `type` (SOCK_STREAM, SOCK_SEQPACKET) that listens at `path`, replacing a
/// socket that a former process has left. Non-blocking. `mode` says who may connect; 0: as the
/// umask says. `backlog`: how many connections may wait to be accepted.
[[nodiscard]] Result<Fd> listen_at(const std::string& path, int type, mode_t mode = 0,
                                   int backlog = SOMAXCONN);

/// The one socket of `type` that systemd has passed, listening and non-blocking; an empty Fd if it
/// has passed none.
[[nodiscard]] Result<Fd> handed_over(int type);

}  // namespace mlcca
