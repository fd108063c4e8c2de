// SPDX-License-Identifier: BSD-2-Clause
// Writes what was generated: only what is new or differs, and never over the work of another
// program or person.
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

enum class FileKind : std::uint8_t {
  text,  ///< ours if it carries kMark
  blob,  ///< ours if it is a DER encoding of a channel
};

struct OutputFile {
  std::string name;
  std::string content;
  FileKind kind = FileKind::text;
};

enum class Written : std::uint8_t { unchanged, created, changed };

/// The folder of the generated files, made if needed.
class TargetFolder {
 public:
  static Result<TargetFolder> open(const std::string& folder);

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

  /// What is wrong with that name: it is a symbolic link, and could lead out of the folder.
  [[nodiscard]] Result<void> check_link(const std::string& name) const;
  /// What is wrong with writing `file`: one of that name is there that we did not generate.
  [[nodiscard]] Result<void> check(const OutputFile& file) const;
  /// The file of that name, of at most `limit` bytes; nullopt if there is none. Never through a
  /// link.
  [[nodiscard]] Result<std::optional<FileContent>> read(const std::string& name,
                                                        std::size_t limit) const {
    return read_file(path(name), limit, Links::refuse);
  }
  /// Each atomically, and all are synced together (FileBatch); a file that has the content already
  /// is not touched. What became of each.
  [[nodiscard]] Result<std::vector<Written>> write(const std::vector<OutputFile>& files) const;
  /// The generated headers in the folder that are not among `names`.
  [[nodiscard]] std::vector<std::string> leftovers(const std::vector<std::string>& names) const;

 private:
  explicit TargetFolder(std::string folder) : folder_(std::move(folder)) {}
  std::string folder_;
};

}  // namespace mlcca::tools::design
