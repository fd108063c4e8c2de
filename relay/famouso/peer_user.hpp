// SPDX-License-Identifier: BSD-2-Clause
// Who is at the other end of a TCP connection within this host: any local user can connect.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/result.hpp"

namespace mlcca::relay {

/// One end of a connection over IPv4, in host order.
struct TcpEnd {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  friend bool operator==(const TcpEnd&, const TcpEnd&) = default;
};

/// The owner of a socket from `local` to `remote`, if a line of /proc/self/net/tcp or tcp6 is
/// of it.
[[nodiscard]] std::optional<uid_t> owner_in_line(std::string_view line, const TcpEnd& local,
                                                 const TcpEnd& remote);

/// The user of the socket at the other end. Error: it is not of this host, or cannot be known.
[[nodiscard]] Result<uid_t> user_at_other_end(int socket);

}  // namespace mlcca::relay
