// SPDX-License-Identifier: BSD-2-Clause
// Looks up users and groups of this machine.
#pragma once
#include <cstdint>
#include <expected>
#include <string>

#include "core/design/findings.hpp"

namespace mlcca::description {

/// Why a user or group has no number.
struct NoUser {
  std::string text;
  /// wrong_place: it is not a valid number; unreadable: it was not found, but may be found at
  /// another time.
  core::FindingId id = core::FindingId::wrong_place;
};

/// The number of a user that is given by name or number. 2^32 - 1 is not a valid number.
std::expected<std::uint32_t, NoUser> uid_of(const std::string& user);

/// The number of a group, in the same way.
std::expected<std::uint32_t, NoUser> gid_of(const std::string& group);

}  // namespace mlcca::description
