// SPDX-License-Identifier: BSD-2-Clause
// Identifies the user at the other end of a TCP connection within this host, because any local user
// can connect.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/result.hpp"

namespace mlcca::relay {

/// One end of a TCP connection over IPv4, in host byte order.
struct TcpEnd {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  friend bool operator==(const TcpEnd&, const TcpEnd&) = default;
};

/// The owner of the socket from `local` to `remote`, if this line of /proc/self/net/tcp or tcp6
/// describes it; otherwise nullopt.
[[nodiscard]] std::optional<uid_t> owner_in_line(std::string_view line, const TcpEnd& local,
                                                 const TcpEnd& remote);

/// The user that owns the other end of the connection. Fails if that is not on this host or cannot
/// be found.
[[nodiscard]] Result<uid_t> user_at_other_end(int socket);

}  // namespace mlcca::relay
