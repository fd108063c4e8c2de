// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/peer_user.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <string>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "base/tcp_table.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

constexpr const char* kTable = "/proc/self/net/tcp";
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
  const TcpColumns columns = tcp_columns(line);
  if (end_in(columns[1]) != local || end_in(columns[2]) != remote) return std::nullopt;
  return number_in<uid_t>(columns[7]);
}

Result<uid_t> user_at_other_end(int socket) {
  const auto here = end_of(socket, ::getsockname);
  const auto there = end_of(socket, ::getpeername);
  if (!here || !there) return fail("it is gone");
  const Fd table(::open(kTable, O_RDONLY | O_CLOEXEC));
  if (!table) return system_error(kTable);
  std::optional<uid_t> owner;
  const int failed = read_tcp_table(table.get(), [&](std::string_view line) {
    owner = owner_in_line(line, *there, *here);
    return !owner;
  });
  if (failed == EFBIG) return fail(std::string(kTable) + ": too many sockets");
  errno = failed;
  if (failed != 0) return system_error(kTable);
  if (!owner) return fail("no socket of this host is its other end");
  return *owner;
}

}  // namespace mlcca::relay
