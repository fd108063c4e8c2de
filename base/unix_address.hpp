// SPDX-License-Identifier: BSD-2-Clause
// The address of a local socket.
#pragma once
#include <sys/socket.h>
#include <sys/un.h>

#include <string>

#include "base/result.hpp"

namespace mlcca {

/// Of a socket in the file system; `path` has 1 to 107 bytes.
inline Result<sockaddr_un> unix_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  constexpr std::size_t most = sizeof address.sun_path - 1;
  if (path.empty() || path.size() > most)
    return fail("socket path '" + path + "': must have 1 to " + std::to_string(most) + " bytes");
  path.copy(address.sun_path, most);
  return address;
}

/// As the calls of the socket interface want it.
inline const sockaddr* generic(const sockaddr_un& address) {
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace mlcca
