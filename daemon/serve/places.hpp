// SPDX-License-Identifier: BSD-2-Clause
// Decides who may have a connection, and whose connection is closed for it. No I/O.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace mlcca::serve {

enum class Standing : std::uint8_t { other, member, root };

/// What a connection is in use for at the moment. Of a user's connections, those with an earlier
/// value are closed first; one that owns an admission is never closed.
enum class Use : std::uint8_t { idle, listens, asks, owns };

/// A connection that exists.
struct Held {
  int id = -1;  ///< a number of the caller's
  uid_t uid = 0;
  Standing standing = Standing::other;
  Use use = Use::idle;
  std::uint64_t active = 0;  ///< when it was last of use, ns
};

/// The decision on one more connection.
struct Admittance {
  std::string refused;          ///< why there is no place; empty: there is one
  std::optional<Held> closes;   ///< must be closed first to make the place
  std::size_t of_its_user = 0;  ///< how many connections the user of `closes` had
};

/// The most connections at once.
constexpr std::size_t kMostPlaces = 256;
/// Of these, the number that is kept free for root, for members of the control group, and for all
/// other users.
constexpr std::size_t kPlacesOfRoot = 16;
constexpr std::size_t kPlacesOfMembers = 32;
constexpr std::size_t kPlacesOfOthers = 32;
/// The most connections of one user. Root may have all.
constexpr std::size_t kMostOfMember = 128;
constexpr std::size_t kMostOfOther = 32;

/// Decides on one more connection of a user, beside those in `held`.
[[nodiscard]] Admittance place_for(uid_t uid, Standing standing, std::span<const Held> held);

}  // namespace mlcca::serve
