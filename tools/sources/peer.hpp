// SPDX-License-Identifier: BSD-2-Clause
// Whose servers are trusted: those of root, of the user of this process, and of the user of mlccad.
// Any user can listen at a port, or at a path in a folder of its own.
#pragma once
#include <sys/types.h>

#include <compare>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "tools/sources/endpoint.hpp"

namespace mlcca::net {

/// Also trusts the user at the other end of this local socket from now on.
Result<void> trust_owner_of(int socket);
/// An error if `owner`, the user of `what`, is not trusted.
[[nodiscard]] Result<void> check_owner(const std::string& what, uid_t owner);
/// Checks who listens at the other end of a connected local socket.
[[nodiscard]] Result<void> check_peer(int socket);

/// A listening socket.
struct Listener {
  std::uint64_t inode = 0;  ///< never reused by the kernel
  uid_t owner = 0;
  auto operator<=>(const Listener&) const = default;
};
using Listeners = std::set<Listener>;

/// Finds, in lines of /proc/net/tcp and tcp6, the sockets that a connection to `to` may reach. The
/// kernel prefers a socket at that very address to one at any address, and for an IPv4 address a
/// socket of IPv4. So any user can listen at [::] beside another user's 127.0.0.1 or 0.0.0.0
/// (IPV6_V6ONLY) without ever being reached there; such a socket must not count.
class Reachable {
 public:
  explicit Reachable(const Endpoint& to);
  ~Reachable();
  Reachable(const Reachable&) = delete;
  Reachable& operator=(const Reachable&) = delete;
  Reachable(Reachable&&) = delete;
  Reachable& operator=(Reachable&&) = delete;

  /// Takes a line; false if its socket does not listen.
  bool take(std::string_view line);
  [[nodiscard]] const Listeners& listeners() const { return best_; }

 private:
  struct Address;
  std::unique_ptr<Address> to_;  ///< empty for the path of a local socket
  int rank_ = 0;
  Listeners best_;
};
/// The reachable listeners in this network namespace; none for a path. An error if one of them
/// belongs to a user that is not trusted.
[[nodiscard]] Result<Listeners> trusted_listeners(const Endpoint& at);

}  // namespace mlcca::net
