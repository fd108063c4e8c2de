// SPDX-License-Identifier: BSD-2-Clause
// The names of users, for people who read who did something. Reads only a file: asking a directory
// service (NSS) could take longer than the heart-beat can wait.
#pragma once
#include <sys/types.h>

#include <ctime>
#include <map>
#include <string>
#include <utility>

namespace mlcca {

/// A cache of the user names in /etc/passwd.
class UserNames {
 public:
  /// Longer files are not read; bytes.
  static constexpr off_t kMostBytes = off_t{1} << 20;

  explicit UserNames(std::string path = "/etc/passwd") : path_(std::move(path)) {}

  /// The name of a user; empty if the file does not name the user or cannot be read. Reads the file
  /// again if it has changed.
  [[nodiscard]] std::string of(uid_t uid);

 private:
  void read();

  std::string path_;
  timespec changed_{};
  ino_t inode_ = 0;
  std::map<uid_t, std::string> names_;
};

}  // namespace mlcca
