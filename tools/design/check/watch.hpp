// SPDX-License-Identifier: BSD-2-Clause
// Waits until one of some files is saved, however the editor does that.
#pragma once
#include <time.h>  // NOLINT(modernize-deprecated-headers): timespec of POSIX

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::tools::design {

/// What wait() has seen.
enum class Woken : std::uint8_t { changed, ended };

/// The time that file systems use for their stamps.
timespec file_time();

class FileWatch {
 public:
  ~FileWatch();
  FileWatch(FileWatch&&) noexcept;
  FileWatch& operator=(FileWatch&&) noexcept;
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  /// From now on SIGINT, SIGTERM and SIGHUP end wait() instead of the process.
  static Result<FileWatch> open();

  /// Watches these files and no others; they need not exist. True if one that was not watched
  /// before has changed since then: that change would go unnoticed.
  Result<bool> follow(const std::vector<std::string>& files, timespec since);

  /// Until one of them is written, replaced, removed or appears. The many events of one save are
  /// one change.
  Result<Woken> wait();

 private:
  /// What counts in one folder.
  struct Folder {
    std::set<std::string> names;
    bool any = false;  ///< it stands for one that does not exist
  };

  FileWatch(Fd events, Fd signals) : events_(std::move(events)), signals_(std::move(signals)) {}
  Result<void> add(const std::string& file);
  Result<bool> take_events();

  Fd events_;
  Fd signals_;
  std::map<int, Folder> folders_;  ///< by watch descriptor
  std::set<std::string> files_;
};

}  // namespace mlcca::tools::design
