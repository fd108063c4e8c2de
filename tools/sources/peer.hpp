// SPDX-License-Identifier: BSD-2-Clause
// Whose word is taken: that of root, of the user who runs this, and of the one who runs mlccad. Any
// user can listen at a port, or at a path in a folder of its own.
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

/// From now on also that of the user at the other end of this local socket.
Result<void> trust_owner_of(int socket);
/// `what` belongs to `owner`: an error in words if that user is not trusted.
[[nodiscard]] Result<void> check_owner(const std::string& what, uid_t owner);
/// Who listens at the other end of a local socket.
[[nodiscard]] Result<void> check_peer(int socket);

/// A socket that listens.
struct Listener {
  std::uint64_t inode = 0;  ///< never used again
  uid_t owner = 0;
  auto operator<=>(const Listener&) const = default;
};
using Listeners = std::set<Listener>;

/// Those in texts of /proc/net/tcp and tcp6 that a connection to `to` may reach. The kernel prefers
/// a socket that listens at that very address to those that listen at all, and to an IPv4 address
/// one of IPv4: any user can listen at [::] beside another one's 127.0.0.1 or 0.0.0.0 (IPV6_V6ONLY)
/// without ever being reached there.
class Reachable {
 public:
  explicit Reachable(const Endpoint& to);
  ~Reachable();
  Reachable(const Reachable&) = delete;
  Reachable& operator=(const Reachable&) = delete;
  Reachable(Reachable&&) = delete;
  Reachable& operator=(Reachable&&) = delete;

  /// One line; false: it is of a socket that does not listen.
  bool take(std::string_view line);
  [[nodiscard]] const Listeners& listeners() const { return best_; }

 private:
  struct Place;
  std::unique_ptr<Place> to_;  ///< none: a path
  int rank_ = 0;
  Listeners best_;
};
/// Those of one text.
[[nodiscard]] Listeners listeners_in(std::string_view text, const Endpoint& to);
/// Those of this network namespace. An error: one of them belongs to a user that is not trusted.
/// None for a path.
[[nodiscard]] Result<Listeners> trusted_listeners(const Endpoint& at);

}  // namespace mlcca::net
