// SPDX-License-Identifier: BSD-2-Clause
// Whose word is taken: that of root, of the user who runs this, and of the one who runs mlccad. Any
// user can listen at a port, or at a path in a folder of its own.
#pragma once
#include <sys/types.h>

#include <compare>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "core/result.hpp"
#include "daemon/sources/endpoint.hpp"

namespace mlcca::net {

/// From now on also that of the user at the other end of this local socket.
Result<void> trust_owner_of(int socket);
/// `what` belongs to `owner`: an error in words if that is nobody we trust.
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

inline constexpr std::size_t kMaxListeners = std::size_t{1} << 20U;  ///< bytes of the kernel's list

/// Those in the text of /proc/net/tcp or tcp6 that a connection to `to` may reach, also by way of
/// any address.
[[nodiscard]] Listeners listeners_in(std::string_view text, const Endpoint& to);
/// Those of this network namespace. An error: one of them belongs to nobody we trust. None for a
/// path.
[[nodiscard]] Result<Listeners> trusted_listeners(const Endpoint& at);

}  // namespace mlcca::net
