// SPDX-License-Identifier: BSD-2-Clause
// The address of a local (AF_UNIX) socket.
#pragma once
#include <sys/socket.h>
#include <sys/un.h>

#include <string>

#include "base/result.hpp"

namespace mlcca {

/// The address of a socket in the file system; an error if `path` does not have 1 to 107 bytes.
inline Result<sockaddr_un> unix_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  constexpr std::size_t most = sizeof address.sun_path - 1;
  if (path.empty() || path.size() > most)
    return fail("socket path '" + path + "': must have 1 to " + std::to_string(most) + " bytes");
  path.copy(address.sun_path, most);
  return address;
}

/// The type that the calls of the socket interface take.
inline const sockaddr* generic(const sockaddr_un& address) {
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace mlcca
