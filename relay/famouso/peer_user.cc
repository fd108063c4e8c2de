// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/peer_user.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "base/tcp_table.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

constexpr std::size_t kWord = 8;  // hexadecimal digits
constexpr std::uint32_t kMapped = 0xffff;
/// The IPv4 address in an address of /proc/net/tcp6. Java and .NET open IPv6 sockets for IPv4 as
/// well: for ::ffff:127.0.0.1, "0000000000000000FFFF00000100007F", it returns "0100007F".
std::string_view ipv4_part(std::string_view address) {
  if (address.size() != 4 * kWord) return address;
  for (std::size_t word = 0; word < 3; ++word)
    if (number_in<std::uint32_t>(address.substr(word * kWord, kWord), kHexadecimalBase) !=
        (word == 2 ? htonl(kMapped) : 0))
      return {};
  return address.substr(3 * kWord);
}

/// Parses e.g. "0100007F:138D": the address as it is in memory, the port as a number.
std::optional<TcpEnd> end_in(std::string_view text) {
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto address = number_in<std::uint32_t>(ipv4_part(text.substr(0, colon)), kHexadecimalBase);
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

/// The request of sock_diag(7) for one TCP socket.
struct Lookup {
  nlmsghdr header{};
  inet_diag_req_v2 body{};
};

inet_diag_sockid id_of(const TcpEnd& local, const TcpEnd& remote) {
  inet_diag_sockid id{};
  id.idiag_sport = htons(local.port);
  id.idiag_dport = htons(remote.port);
  id.idiag_src[0] = htonl(local.address);
  id.idiag_dst[0] = htonl(remote.address);
  id.idiag_cookie[0] = id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  return id;
}

/// Whether both have the same ends. IPv6 sockets that speak IPv4 have them in the same form, or as
/// ::ffff:a.b.c.d.
bool has_ends_of(const inet_diag_msg& found, const inet_diag_sockid& wanted) {
  const std::size_t at = found.idiag_family == AF_INET6 ? 3 : 0;
  const inet_diag_sockid& id = found.id;
  return id.idiag_sport == wanted.idiag_sport && id.idiag_dport == wanted.idiag_dport &&
         id.idiag_src[at] == wanted.idiag_src[0] && id.idiag_dst[at] == wanted.idiag_dst[0];
}

/// Asks the kernel for this socket alone. Nullopt: there is none, or its program has closed it. An
/// error: this kernel, or a sandbox, does not allow to ask.
Result<std::optional<uid_t>> owner_by_diag(const TcpEnd& local, const TcpEnd& remote) {
  const Fd socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
  if (!socket) return system_error("NETLINK_SOCK_DIAG");
  Lookup ask;
  ask.header.nlmsg_len = sizeof ask;
  ask.header.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  ask.header.nlmsg_flags = NLM_F_REQUEST;
  ask.body.sdiag_family = AF_INET;
  ask.body.sdiag_protocol = IPPROTO_TCP;
  ask.body.idiag_states = ~std::uint32_t{0};
  ask.body.id = id_of(local, remote);
  if (::send(socket.get(), &ask, sizeof ask, 0) < 0) return system_error("NETLINK_SOCK_DIAG");
  // The kernel has answered before send() returned.
  alignas(nlmsghdr) std::array<char, 4096> answer{};
  const ssize_t size = ::recv(socket.get(), answer.data(), answer.size(), MSG_DONTWAIT);
  if (size < 0) return system_error("NETLINK_SOCK_DIAG");
  nlmsghdr header{};
  const auto bytes = static_cast<std::size_t>(size);
  if (bytes < sizeof header + sizeof(nlmsgerr::error)) return fail("NETLINK_SOCK_DIAG: too short");
  std::memcpy(&header, answer.data(), sizeof header);
  if (header.nlmsg_type == NLMSG_ERROR) {
    int error = 0;
    std::memcpy(&error, &answer[NLMSG_HDRLEN], sizeof error);
    if (error == -ENOENT) return std::optional<uid_t>();
    return system_error("NETLINK_SOCK_DIAG", -error);
  }
  inet_diag_msg found{};
  if (header.nlmsg_type != SOCK_DIAG_BY_FAMILY || bytes < NLMSG_HDRLEN + sizeof found)
    return fail("NETLINK_SOCK_DIAG: no answer");
  std::memcpy(&found, &answer[NLMSG_HDRLEN], sizeof found);
  // Without such a connection the kernel finds the socket that listens at its local end. A closed
  // socket has no inode, and root as its owner.
  if (!has_ends_of(found, ask.body.id) || found.idiag_inode == 0) return std::optional<uid_t>();
  return std::optional<uid_t>(found.idiag_uid);
}

Result<std::optional<uid_t>> owner_in(const char* path, const TcpEnd& local, const TcpEnd& remote) {
  const Fd table(::open(path, O_RDONLY | O_CLOEXEC));
  std::optional<uid_t> owner;
  if (!table && errno == ENOENT) return owner;  // the kernel has no IPv6
  if (!table) return system_error(path);
  const int failed = read_tcp_table(table.get(), [&](std::string_view line) {
    owner = owner_in_line(line, local, remote);
    return !owner;
  });
  if (failed == EFBIG) return fail(std::string(path) + ": too many sockets");
  errno = failed;
  if (failed != 0) return system_error(path);
  return owner;
}

}  // namespace

std::optional<uid_t> owner_in_line(std::string_view line, const TcpEnd& local,
                                   const TcpEnd& remote) {
  const TcpColumns columns = tcp_columns(line);
  if (end_in(columns[1]) != local || end_in(columns[2]) != remote) return std::nullopt;
  // A closed socket has no inode, and the table shows root as its owner.
  if (columns[9] == "0") return std::nullopt;
  return number_in<uid_t>(columns[7]);
}

Result<uid_t> user_at_other_end(int socket) {
  const auto here = end_of(socket, ::getsockname);
  const auto there = end_of(socket, ::getpeername);
  if (!here || !there) return fail("it is gone");
  if (const auto owner = owner_by_diag(*there, *here)) {
    if (*owner) return **owner;
    return fail("no open socket of this host is its other end");
  }
  // Kernels without INET_DIAG. The tables are long if there are many sockets.
  for (const char* path : {"/proc/self/net/tcp", "/proc/self/net/tcp6"}) {
    const auto owner = owner_in(path, *there, *here);
    if (!owner) return std::unexpected(owner.error());
    if (*owner) return **owner;
  }
  return fail("no open socket of this host is its other end");
}

}  // namespace mlcca::relay
