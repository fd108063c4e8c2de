// SPDX-License-Identifier: BSD-2-Clause
// Who may have a connection, and whose is closed for it. No I/O.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace mlcca::serve {

enum class Standing : std::uint8_t { other, member, root };

/// What a connection is there for at the moment. The later ones are closed the later; one that owns
/// an admission, never.
enum class Use : std::uint8_t { idle, listens, asks, owns };

struct Held {
  int id = -1;  ///< of the caller's
  uid_t uid = 0;
  Standing standing = Standing::other;
  Use use = Use::idle;
  std::uint64_t active = 0;  ///< when it was last of use, ns
};

struct Place {
  std::string refused;          ///< why; otherwise there is a place,
  std::optional<Held> closes;   ///< once this one is closed,
  std::size_t of_its_user = 0;  ///< who had so many
};

/// Connections at once.
constexpr std::size_t kMostPlaces = 256;
/// Of these, kept free for root; for members of the control group; for all other users.
constexpr std::size_t kPlacesOfRoot = 16;
constexpr std::size_t kPlacesOfMembers = 32;
constexpr std::size_t kPlacesOfOthers = 32;
/// For one user; root may have all.
constexpr std::size_t kMostOfMember = 128;
constexpr std::size_t kMostOfOther = 32;

/// For one more connection of a user.
[[nodiscard]] Place place_for(uid_t uid, Standing standing, std::span<const Held> held);

}  // namespace mlcca::serve
