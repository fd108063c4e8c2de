// SPDX-License-Identifier: BSD-2-Clause
// Looks up users and groups with the reentrant functions of the C library.
#include "description/users.hpp"

#include <fmt/format.h>
#include <grp.h>
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

constexpr std::size_t kMostBytes = std::size_t{1} << 20U;  // bytes of one entry

/// `kind`: "user" or "group". `look_up`: getpwnam_r or a similar function. `number`: returns the
/// number in an entry.
template <class Entry, class LookUp, class Number>
std::expected<std::uint32_t, NoUser> number_of(std::string_view kind, const std::string& name,
                                               LookUp look_up, Number number) {
  if (name.find_first_not_of("0123456789") == std::string::npos) {
    const auto stated = number_in<std::uint32_t>(name);
    if (stated && *stated != std::numeric_limits<std::uint32_t>::max()) return *stated;
    return std::unexpected(
        NoUser{fmt::format("{0} {1} is not a {0} number: at most 4294967294", kind, name)});
  }
  std::vector<char> buffer(1024);
  Entry entry{};
  Entry* found = nullptr;
  int error = ERANGE;
  while (error == ERANGE && buffer.size() < kMostBytes) {
    buffer.resize(buffer.size() * 2);
    error = look_up(name.c_str(), &entry, buffer.data(), buffer.size(), &found);
  }
  if (found != nullptr) return number(entry);
  if (error != 0)
    return std::unexpected(NoUser{fmt::format("{} {} cannot be looked up: {}", kind, name,
                                              std::strerror(error)),  // NOLINT(*-mt-unsafe)
                                  core::FindingId::unreadable});
  // The C library reports the same if a database cannot be opened or does not exist yet.
  return std::unexpected(NoUser{
      fmt::format("{0} {1} is not known on this machine: add the {0} or give a number", kind, name),
      core::FindingId::unreadable});
}

}  // namespace

std::expected<std::uint32_t, NoUser> uid_of(const std::string& user) {
  return number_of<passwd>("user", user, ::getpwnam_r,
                           [](const passwd& entry) { return entry.pw_uid; });
}

std::expected<std::uint32_t, NoUser> gid_of(const std::string& group) {
  return number_of<::group>("group", group, ::getgrnam_r,
                            [](const ::group& entry) { return entry.gr_gid; });
}

}  // namespace mlcca::description
