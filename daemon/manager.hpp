// SPDX-License-Identifier: BSD-2-Clause
// What is reported to the service manager and to readers of a log. Nothing here ever waits for
// them: the heart-beat comes first.
#pragma once
#include <sys/uio.h>

#include <span>
#include <string>
#include <string_view>

#include "base/handle.hpp"

namespace mlcca {

/// One datagram to a socket of that path ("@…" is in the abstract namespace), in the protocol of
/// its reader. False where it would have to wait because no process reads, or where none listens.
[[nodiscard]] bool send_at_once(const std::string& path, std::span<const iovec> parts);

/// As sd_notify(3), which waits without end while no process reads the socket: lines such as
/// "READY=1". True where it was said, or where there is no service manager.
bool notify(std::string_view lines);

/// A pipe or terminal once more, without waiting: O_NONBLOCK of `fd` itself would hold for all who
/// share it. None: it is something else, or cannot be opened again.
[[nodiscard]] Fd opened_at_once(int fd);

/// To an open file, pipe, socket or terminal, also one that others share and that blocks. False
/// where some of it would have to wait because no process reads: that is lost.
bool write_at_once(int fd, std::string_view text);

}  // namespace mlcca
