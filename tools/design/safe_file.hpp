// SPDX-License-Identifier: BSD-2-Clause
// Reads and replaces files atomically: a reader sees the old content or the new one.
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

/// A file and its state when it was read.
struct FileContent {
  std::string path;  ///< symbolic links are resolved, unless they are refused
  std::string text;
  struct stat status{};
};

/// Whether a path whose last component is a symbolic link is followed or refused.
enum class Links : std::uint8_t { follow, refuse };

/// Reads the regular file `path` of at most `limit` bytes; nullopt if there is none.
Result<std::optional<FileContent>> read_file(const std::string& path, std::size_t limit,
                                             Links links = Links::follow);

/// Reads standard input of at most `limit` bytes.
Result<std::string> read_standard_input(std::size_t limit);

/// Replaces the file `old` by `text`, with the same mode and owner: writes and syncs a file beside
/// it, then renames that. An error, without a change, if the file has changed since it was read.
Result<void> replace_file(const FileContent& old, std::string_view text);

/// The error of a file that is to be created and is there already.
[[nodiscard]] std::string existing_words(const std::string& path);

/// Creates `path` in the same way; an error if it exists by then.
Result<void> create_file(const std::string& path, std::string_view text);

/// Replaces and creates many files of one folder as replace_file() and create_file() do, but syncs
/// all together: one sync for each file takes most of the time for thousands of small files.
class FileBatch {
 public:
  explicit FileBatch(std::string folder);
  FileBatch(const FileBatch&) = delete;
  FileBatch(FileBatch&&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  FileBatch& operator=(FileBatch&&) = delete;
  /// Removes what was not committed.
  ~FileBatch();

  /// Writes a temporary file beside the one that it will replace or create.
  Result<void> replace(FileContent old, std::string_view text);
  Result<void> create(const std::string& path, std::string_view text);
  /// Syncs all files, then renames them one by one in their order. After an error the files before
  /// it are in place and the others unchanged.
  Result<void> commit();

 private:
  struct Pending;
  std::string folder_;
  std::vector<std::unique_ptr<Pending>> pending_;
};

}  // namespace mlcca::tools::design
