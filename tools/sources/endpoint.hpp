// SPDX-License-Identifier: BSD-2-Clause
// Parses the addresses of servers that are link sources.
#pragma once
#include <sys/socket.h>

#include <string>

#include "base/result.hpp"

namespace mlcca::net {

/// The address of a server.
struct Endpoint {
  sockaddr_storage address{};
  socklen_t size = 0;
  std::string text;  ///< as it was stated
};

/// Parses HOST:PORT or [HOST]:PORT with a numeric host, or the absolute path of a socket.
[[nodiscard]] Result<Endpoint> parse_endpoint(const std::string& text);

}  // namespace mlcca::net
