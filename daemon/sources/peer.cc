// SPDX-License-Identifier: BSD-2-Clause
// The kernel does not tell a client who is at the other end of a TCP connection, but whose every
// socket of this machine is (proc_net(5)). A connection that was accepted and closed has no owner
// any more; that which listens has, as long as it does. So it must listen before and after.
#include "daemon/sources/peer.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "core/handle.hpp"
#include "daemon/net/sources/timer.hpp"

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
    return fail(system_error("SO_PEERCRED", errno));
  return owner.uid;
}

using Address = std::array<std::uint8_t, 16>;  // IPv4 in the last four, as ::ffff:a.b.c.d

Address mapped(std::span<const std::uint8_t> v4) {
  Address out{};
  out[10] = out[11] = 0xff;
  std::ranges::copy(v4, out.begin() + 12);
  return out;
}

/// Any address of one of the families.
bool is_any(const Address& address) {
  return address == Address{} || address == mapped(std::array<std::uint8_t, 4>{});
}

struct Place {
  Address address{};
  std::uint16_t port = 0;
};

std::optional<Place> place_of(const Endpoint& endpoint) {
  Place out;
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

template <class Integer>
std::optional<Integer> number(std::string_view text, int base) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// "0100007F:07D9": words of the address as this machine has them, and the port.
std::optional<Place> read_place(std::string_view text) {
  const auto colon = text.find(':');
  if (colon != 8 && colon != 32) return std::nullopt;
  std::vector<std::uint8_t> octets(colon / 2);
  for (std::size_t at = 0; at < colon; at += 8) {
    const auto word = number<std::uint32_t>(text.substr(at, 8), 16);
    if (!word) return std::nullopt;
    std::memcpy(octets.data() + at / 2, &*word, sizeof *word);
  }
  const auto port = number<std::uint16_t>(text.substr(colon + 1), 16);
  if (!port) return std::nullopt;
  Place out{.address = {}, .port = *port};
  if (colon == 8)
    out.address = mapped(octets);
  else
    std::ranges::copy(octets, out.address.begin());
  return out;
}

/// The first ten columns of a line: local address 1, state 3, owner 7, inode 9.
using Columns = std::array<std::string_view, 10>;
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

/// Those who listen come first: what follows is not read.
Result<std::string> read_listeners(const char* path) {
  const Fd file(::open(path, O_RDONLY | O_CLOEXEC));
  if (!file && errno == ENOENT) return std::string{};  // no IPv6
  if (!file) return fail(system_error(path, errno));
  std::string text;
  std::array<char, 4096> block{};
  for (;;) {
    const auto size = ::read(file.get(), block.data(), block.size());
    if (size < 0) return fail(system_error(path, errno));
    if (size == 0) return text;
    const auto latest = text.size();
    text.append(block.data(), static_cast<std::size_t>(size));
    if (text.size() > kMaxListeners) return fail(std::string(path) + ": too many sockets listen");
    const auto line = text.rfind('\n', text.size() - 2);
    if (latest == 0 || line == std::string::npos || !text.ends_with('\n')) continue;
    if (columns_of(std::string_view(text).substr(line + 1))[3] != kListens) return text;
  }
}

}  // namespace

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

Listeners listeners_in(std::string_view text, const Endpoint& to) {
  Listeners out;
  const auto wanted = place_of(to);
  while (wanted && !text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto columns = columns_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (columns[3] != kListens) continue;
    const auto place = read_place(columns[1]);
    if (!place || place->port != wanted->port) continue;
    if (place->address != wanted->address && !is_any(place->address)) continue;
    const auto owner = number<uid_t>(columns[7], 10);
    const auto inode = number<std::uint64_t>(columns[9], 10);
    if (owner && inode) out.insert({.inode = *inode, .owner = *owner});
  }
  return out;
}

Result<Listeners> trusted_listeners(const Endpoint& at) {
  Listeners out;
  if (!place_of(at)) return out;
  for (const char* path : {"/proc/self/net/tcp", "/proc/self/net/tcp6"}) {
    const auto text = read_listeners(path);
    if (!text) return std::unexpected(text.error());
    out.merge(listeners_in(*text, at));
  }
  for (const Listener& listener : out)
    if (auto checked = check_owner("the socket that listens there", listener.owner); !checked)
      return std::unexpected(checked.error());
  return out;
}

}  // namespace mlcca::net
