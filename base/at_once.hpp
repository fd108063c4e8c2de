// SPDX-License-Identifier: BSD-2-Clause
// Reports to the service manager and to readers of a log. Nothing here waits for them, because the
// heart-beat comes first.
#pragma once
#include <sys/uio.h>

#include <span>
#include <string>
#include <string_view>

#include "base/handle.hpp"

namespace mlcca {

/// Sends one datagram to the socket at `path` ("@…": in the abstract namespace), in the protocol of
/// its reader. False if it would have to wait because no process reads, or if no process listens.
[[nodiscard]] bool send_at_once(const std::string& path, std::span<const iovec> parts);

/// Like sd_notify(3), which waits without limit if no process reads the socket. `lines` is for
/// example "READY=1". True if it was sent, or if there is no service manager.
bool notify(std::string_view lines);

/// A second, non-blocking descriptor for a pipe or terminal. O_NONBLOCK on `fd` itself would apply
/// to all processes that share it. Empty if it is something else, or cannot be opened again.
[[nodiscard]] Fd opened_at_once(int fd);

/// Writes to an open file, pipe, socket or terminal, also a blocking one that others share. False
/// if some of the text would have to wait because no process reads; that part is lost.
bool write_at_once(int fd, std::string_view text);

}  // namespace mlcca
