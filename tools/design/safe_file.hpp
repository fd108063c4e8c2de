// SPDX-License-Identifier: BSD-2-Clause
// Files that are read whole and replaced whole: whoever looks sees the old content or the new.
#pragma once
#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

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

}  // namespace mlcca::tools::design
