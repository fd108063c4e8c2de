// SPDX-License-Identifier: BSD-2-Clause
// The user database, without its static buffers.
#include "description/users.hpp"

#include <fmt/format.h>
#include <pwd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

#include "base/number.hpp"

namespace mlcca::description {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20U;  // of one entry

}  // namespace

std::expected<std::uint32_t, NoUser> uid_of(const std::string& user) {
  if (user.find_first_not_of("0123456789") == std::string::npos) {
    const auto uid = number_in<std::uint32_t>(user);
    if (uid && *uid != std::numeric_limits<std::uint32_t>::max()) return *uid;
    return std::unexpected(
        NoUser{fmt::format("user {} is not a user number: at most 4294967294", user)});
  }
  std::vector<char> buffer(1024);
  passwd entry{};
  passwd* found = nullptr;
  int error = ERANGE;
  while (error == ERANGE && buffer.size() < kMostBytes) {
    buffer.resize(buffer.size() * 2);
    error = getpwnam_r(user.c_str(), &entry, buffer.data(), buffer.size(), &found);
  }
  if (found != nullptr) return entry.pw_uid;
  if (error != 0)
    return std::unexpected(NoUser{fmt::format("user {} cannot be looked up: {}", user,
                                              std::strerror(error)),  // NOLINT(*-mt-unsafe)
                                  core::FindingId::unreadable});
  // The C library says the same where a user database cannot be opened, or is not there yet.
  return std::unexpected(NoUser{
      fmt::format("user {} is not known on this machine: add the user or give a number", user),
      core::FindingId::unreadable});
}

}  // namespace mlcca::description
