// SPDX-License-Identifier: BSD-2-Clause
// Users of this machine.
#pragma once
#include <cstdint>
#include <expected>
#include <string>

#include "core/design/findings.hpp"

namespace mlcca::description {

/// Why a user has no number.
struct NoUser {
  std::string text;
  /// wrong_place: it is no number; unreadable: it was not found, and may be found another time.
  core::FindingId id = core::FindingId::wrong_place;
};

/// The number of a user who is given by name or number. 2^32 - 1 is nobody's number.
std::expected<std::uint32_t, NoUser> uid_of(const std::string& user);

/// The same of a group.
std::expected<std::uint32_t, NoUser> gid_of(const std::string& group);

}  // namespace mlcca::description
