// SPDX-License-Identifier: BSD-2-Clause
// Trust in the server of a TCP connection. The kernel does not report the peer of a TCP connection,
// but it lists the owner of every socket of this machine (proc_net(5)). A connection that was
// accepted and closed has no owner any more, but a listening socket has one as long as it listens.
// So the same socket must listen before and after connecting.
#include "tools/sources/peer.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "base/system_error.hpp"
#include "base/tcp_table.hpp"

namespace mlcca::net {
namespace {

constexpr std::string_view kListens = "0A";

std::set<uid_t>& trusted() {
  static std::set<uid_t> all{0, ::geteuid()};
  return all;
}

Result<uid_t> owner_of(int socket) {
  ucred owner{};
  socklen_t size = sizeof owner;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &owner, &size) < 0)
    return system_error("SO_PEERCRED");
  return owner.uid;
}

using Address = std::array<std::uint8_t, 16>;  // IPv4 addresses in the last four octets, as
                                               // ::ffff:a.b.c.d

Address mapped(std::span<const std::uint8_t> v4) {
  Address out{};
  out[10] = out[11] = 0xff;
  std::ranges::copy(v4, out.begin() + 12);
  return out;
}

struct At {
  Address address{};
  std::uint16_t port = 0;
};

bool is_v4(const Address& address) {
  const Address none = mapped(std::array<std::uint8_t, 4>{});
  return std::equal(address.begin(), address.begin() + 12, none.begin());
}

/// The precedence that the kernel gives a socket listening at `listens` for a connection to `to`;
/// 0: it is never reached.
int rank_of(const At& listens, const At& to) {
  if (listens.port != to.port) return 0;
  if (listens.address == to.address) return 3;
  if (is_v4(to.address) && listens.address == mapped(std::array<std::uint8_t, 4>{})) return 2;
  return listens.address == Address{} ? 1 : 0;
}

std::optional<At> place_of(const Endpoint& endpoint) {
  At out;
  if (endpoint.address.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &endpoint.address, sizeof v4);
    std::array<std::uint8_t, 4> octets{};
    std::memcpy(octets.data(), &v4.sin_addr, octets.size());
    out = {.address = mapped(octets), .port = ntohs(v4.sin_port)};
    return out;
  }
  if (endpoint.address.ss_family != AF_INET6) return std::nullopt;
  sockaddr_in6 v6{};
  std::memcpy(&v6, &endpoint.address, sizeof v6);
  std::memcpy(out.address.data(), &v6.sin6_addr, out.address.size());
  out.port = ntohs(v6.sin6_port);
  return out;
}

/// Parses "0100007F:07D9": words of the address in host byte order, and the port.
std::optional<At> read_place(std::string_view text) {
  const auto colon = text.find(':');
  if (colon != 8 && colon != 32) return std::nullopt;
  std::vector<std::uint8_t> octets(colon / 2);
  for (std::size_t at = 0; at < colon; at += 8) {
    const auto word = number_in<std::uint32_t>(text.substr(at, 8), 16);
    if (!word) return std::nullopt;
    std::memcpy(octets.data() + at / 2, &*word, sizeof *word);
  }
  const auto port = number_in<std::uint16_t>(text.substr(colon + 1), 16);
  if (!port) return std::nullopt;
  At out{.address = {}, .port = *port};
  if (colon == 8)
    out.address = mapped(octets);
  else
    std::ranges::copy(octets, out.address.begin());
  return out;
}

/// Reads the listening sockets, which come first in the table; the rest is not read.
Result<void> read_listeners(const char* path, Reachable& to) {
  const Fd file(::open(path, O_RDONLY | O_CLOEXEC));
  if (!file && errno == ENOENT) return {};  // no IPv6
  if (!file) return system_error(path);
  bool is_head = true;
  const int failed = read_tcp_table(file.get(), [&](std::string_view line) {
    return to.take(line) || std::exchange(is_head, false);
  });
  if (failed == EFBIG) return fail(std::string(path) + ": too many sockets listen");
  if (failed != 0) return system_error(path, failed);
  return {};
}

}  // namespace

struct Reachable::Address : At {};

Reachable::Reachable(const Endpoint& to) {
  if (const auto place = place_of(to)) to_ = std::make_unique<Address>(*place);
}
Reachable::~Reachable() = default;

bool Reachable::take(std::string_view line) {
  const auto columns = tcp_columns(line);
  if (columns[3] != kListens) return false;
  const auto place = read_place(columns[1]);
  const int rank = to_ && place ? rank_of(*place, *to_) : 0;
  if (rank == 0 || rank < rank_) return true;
  const auto owner = number_in<uid_t>(columns[7], 10);
  const auto inode = number_in<std::uint64_t>(columns[9], 10);
  if (!owner || !inode) return true;
  if (rank > rank_) best_.clear();
  rank_ = rank;
  best_.insert({.inode = *inode, .owner = *owner});
  return true;
}

Result<void> trust_owner_of(int socket) {
  const auto owner = owner_of(socket);
  if (!owner) return std::unexpected(owner.error());
  trusted().insert(*owner);
  return {};
}

Result<void> check_owner(const std::string& what, uid_t owner) {
  if (trusted().contains(owner)) return {};
  return fail(what + " belongs to uid " + std::to_string(owner) +
              ": only what belongs to root or to the user of mlccad is believed");
}

Result<void> check_peer(int socket) {
  const auto owner = owner_of(socket);
  if (!owner) return std::unexpected(owner.error());
  return check_owner("the socket that listens there", *owner);
}

Result<Listeners> trusted_listeners(const Endpoint& at) {
  if (!place_of(at)) return Listeners{};
  Reachable reachable(at);
  for (const char* path : {"/proc/self/net/tcp", "/proc/self/net/tcp6"})
    if (auto read = read_listeners(path, reachable); !read) return std::unexpected(read.error());
  for (const Listener& listener : reachable.listeners())
    if (auto checked = check_owner("the socket that listens there", listener.owner); !checked)
      return std::unexpected(checked.error());
  return reachable.listeners();
}

}  // namespace mlcca::net
