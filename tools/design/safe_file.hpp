// SPDX-License-Identifier: BSD-2-Clause
// Files that are read and replaced as a whole: a reader sees the old content or the new one.
#pragma once
#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// A file as it was when it was read.
struct FileContent {
  std::string path;  ///< with symbolic links followed, unless they are refused
  std::string text;
  struct stat status{};
};

/// What becomes of a path whose last part is a symbolic link.
enum class Links : std::uint8_t { follow, refuse };

/// The regular file `path`, of at most `limit` bytes; nullopt if there is none.
Result<std::optional<FileContent>> read_file(const std::string& path, std::size_t limit,
                                             Links links = Links::follow);

/// Puts `text` in the place of `old`, with the same mode and owner: written and synced beside it,
/// then renamed. Refused, and nothing happens, if the file has changed since it was read.
Result<void> replace_file(const FileContent& old, std::string_view text);

/// Creates `path` in the same way. Refused if it exists by then.
Result<void> create_file(const std::string& path, std::string_view text);

/// Many files of one folder, each as replace_file() and create_file() do it, and all synced
/// together: one sync a file is most of the time that thousands of small ones take.
class FileBatch {
 public:
  explicit FileBatch(std::string folder);
  FileBatch(const FileBatch&) = delete;
  FileBatch(FileBatch&&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  FileBatch& operator=(FileBatch&&) = delete;
  /// What was not committed is removed.
  ~FileBatch();

  /// Written beside the file that it shall become.
  Result<void> replace(FileContent old, std::string_view text);
  Result<void> create(const std::string& path, std::string_view text);
  /// Syncs all of them, then renames one after the other, in their order. With an error those
  /// before it are there, and the others are as they were.
  Result<void> commit();

 private:
  struct Pending;
  std::string folder_;
  std::vector<std::unique_ptr<Pending>> pending_;
};

}  // namespace mlcca::tools::design
