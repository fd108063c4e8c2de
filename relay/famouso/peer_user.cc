// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/peer_user.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

constexpr const char* kTable = "/proc/net/tcp";
/// Bytes of it: some 400,000 sockets.
constexpr std::size_t kMostTableBytes = std::size_t{64} << 20U;

/// The first columns of a line: local end 1, remote end 2, owner 7.
using Columns = std::array<std::string_view, 8>;
Columns columns_of(std::string_view line) {
  Columns out;
  for (auto& column : out) {
    const auto begin = std::min(line.find_first_not_of(' '), line.size());
    const auto end = std::min(line.find(' ', begin), line.size());
    column = line.substr(begin, end - begin);
    line.remove_prefix(end);
  }
  return out;
}

/// "0100007F:138D": the address as it is in memory, the port as a number.
std::optional<TcpEnd> end_in(std::string_view text) {
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto address = number_in<std::uint32_t>(text.substr(0, colon), kHexadecimalBase);
  const auto port = number_in<std::uint16_t>(text.substr(colon + 1), kHexadecimalBase);
  if (!address || !port) return std::nullopt;
  return TcpEnd{.address = ntohl(*address), .port = *port};
}

using NameOf = int(int, sockaddr*, socklen_t*);
std::optional<TcpEnd> end_of(int socket, NameOf* name_of) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (name_of(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      address.sin_family != AF_INET)
    return std::nullopt;
  return TcpEnd{.address = ntohl(address.sin_addr.s_addr), .port = ntohs(address.sin_port)};
}

}  // namespace

std::optional<uid_t> owner_in_line(std::string_view line, const TcpEnd& local,
                                   const TcpEnd& remote) {
  const Columns columns = columns_of(line);
  if (end_in(columns[1]) != local || end_in(columns[2]) != remote) return std::nullopt;
  return number_in<uid_t>(columns[7]);
}

Result<uid_t> user_at_other_end(int socket) {
  const auto here = end_of(socket, ::getsockname);
  const auto there = end_of(socket, ::getpeername);
  if (!here || !there) return fail("it is gone");
  const Fd table(::open(kTable, O_RDONLY | O_CLOEXEC));
  if (!table) return system_error(kTable);
  std::string rest;  // of a line
  std::array<char, 16384> block{};
  for (std::size_t all = 0; all <= kMostTableBytes;) {
    const ssize_t size = ::read(table.get(), block.data(), block.size());
    if (size < 0) return system_error(kTable);
    if (size == 0) return fail("no socket of this host is its other end");
    all += static_cast<std::size_t>(size);
    rest.append(block.data(), static_cast<std::size_t>(size));
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = rest.find('\n', begin)) != std::string::npos;
         begin = end + 1) {
      const auto line = std::string_view(rest).substr(begin, end - begin);
      if (const auto owner = owner_in_line(line, *there, *here)) return *owner;
    }
    rest.erase(0, begin);
  }
  return fail(std::string(kTable) + ": too many sockets");
}

}  // namespace mlcca::relay
