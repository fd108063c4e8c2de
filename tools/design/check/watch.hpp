// SPDX-License-Identifier: BSD-2-Clause
// Waits until one of several files is saved, in whatever way the editor does that (inotify(7)).
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

/// Why wait() has returned.
enum class Woken : std::uint8_t { changed, ended };

/// The present time by the clock of file time stamps (CLOCK_REALTIME_COARSE).
timespec file_time();

/// Watches files through the folders that contain them.
class FileWatch {
 public:
  ~FileWatch();
  FileWatch(FileWatch&&) noexcept;
  FileWatch& operator=(FileWatch&&) noexcept;
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  /// Opens the watch. From then on SIGINT, SIGTERM and SIGHUP end wait() and not the process.
  static Result<FileWatch> open();

  /// Watches these files instead of the former ones; they need not exist. True if a newly watched
  /// file has changed since `since`, a change that wait() would miss.
  Result<bool> follow(const std::vector<std::string>& files, timespec since);

  /// Waits until a file is written, replaced, removed or created. The events of one save count as
  /// one change.
  Result<Woken> wait();

 private:
  /// The file names that are watched in a folder.
  struct Folder {
    std::set<std::string> names;
    bool any = false;  ///< all names count, because it is an ancestor of a folder that does not
                       ///< exist
  };

  FileWatch(Fd events, Fd signals) : events_(std::move(events)), signals_(std::move(signals)) {}
  Result<void> add(const std::string& file);
  Result<bool> take_events();

  Fd events_;
  Fd signals_;
  std::map<int, Folder> folders_;  ///< by inotify watch descriptor
  std::set<std::string> files_;
};

}  // namespace mlcca::tools::design
