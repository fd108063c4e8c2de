// SPDX-License-Identifier: BSD-2-Clause
// Writes generated files: only new and changed ones, and never over a file that was not generated.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "tools/design/safe_file.hpp"

namespace mlcca::tools::design {

/// How a file that exists is recognised as one that we generated.
enum class FileKind : std::uint8_t {
  text,  ///< ours if it contains kMark
  blob,  ///< ours if it is a DER encoding of a channel
};

/// A file to be written.
struct OutputFile {
  std::string name;
  std::string content;
  FileKind kind = FileKind::text;
};

/// What was done with a file.
enum class Written : std::uint8_t { unchanged, created, changed };

/// The folder for generated files.
class TargetFolder {
 public:
  /// Opens the folder and creates it if necessary.
  static Result<TargetFolder> open(const std::string& folder);

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

  /// An error if that name is a symbolic link, which could lead out of the folder.
  [[nodiscard]] Result<void> check_link(const std::string& name) const;
  /// An error if a file of that name exists that we did not generate.
  [[nodiscard]] Result<void> check(const OutputFile& file) const;
  /// The content of a file of at most `limit` bytes; nullopt if there is none. Symbolic links are
  /// refused.
  [[nodiscard]] Result<std::optional<FileContent>> read(const std::string& name,
                                                        std::size_t limit) const {
    return read_file(path(name), limit, Links::refuse);
  }
  /// Writes each file atomically and syncs all together (FileBatch). A file that has the content
  /// already is not touched. Returns what was done with each file.
  [[nodiscard]] Result<std::vector<Written>> write(const std::vector<OutputFile>& files) const;
  /// Generated headers in the folder that are not among `names`.
  [[nodiscard]] std::vector<std::string> leftovers(const std::vector<std::string>& names) const;

 private:
  explicit TargetFolder(std::string folder) : folder_(std::move(folder)) {}
  std::string folder_;
};

}  // namespace mlcca::tools::design
