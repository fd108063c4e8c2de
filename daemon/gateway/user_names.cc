// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/user_names.hpp"

#include <pwd.h>
#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <memory>

namespace mlcca {

std::string UserNames::of(uid_t uid) {
  struct stat now{};
  if (::stat(path_.c_str(), &now) < 0 || !S_ISREG(now.st_mode) || now.st_size > kMostBytes)
    return {};
  if (now.st_ino != inode_ || now.st_mtim.tv_sec != changed_.tv_sec ||
      now.st_mtim.tv_nsec != changed_.tv_nsec) {
    inode_ = now.st_ino;
    changed_ = now.st_mtim;
    read();
  }
  const auto known = names_.find(uid);
  return known == names_.end() ? std::string() : known->second;
}

/// The first entry of a user counts.
void UserNames::read() {
  names_.clear();
  const auto close = [](FILE* f) { static_cast<void>(std::fclose(f)); };
  const std::unique_ptr<FILE, decltype(close)> file(std::fopen(path_.c_str(), "re"), close);
  if (!file) return;
  std::array<char, 16384> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  while (::fgetpwent_r(file.get(), &entry, buffer.data(), buffer.size(), &found) == 0)
    names_.try_emplace(found->pw_uid, found->pw_name);
}

}  // namespace mlcca
