// SPDX-License-Identifier: BSD-2-Clause
// Collects the problems of a description. Their texts are safe to print and bounded in size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/design/findings.hpp"
#include "core/model/system.hpp"
#include "description/read.hpp"

namespace mlcca::description {

/// Problems that are kept.
inline constexpr std::size_t kMaxProblems = 1000;

/// Longest text of a problem in bytes; the rest is cut. A hostile file must not make the answer
/// larger than itself.
inline constexpr std::size_t kMaxProblemText = 480;

/// The text, or as many complete UTF-8 characters as fit into `bytes` together with an ellipsis.
std::string clipped(std::string_view text, std::size_t bytes);

/// The problems found so far, each with its file, line and element.
class Problems {
 public:
  /// `file`: the first file, which gets number 0 and is the current one.
  explicit Problems(std::string file) : files_{std::move(file)} {}

  /// The number of a file: an unknown file gets the next one.
  std::uint32_t add_file(const std::string& file);
  /// Sets the file of problems that are added with a line only. `file`: a number of add_file().
  void set_file(std::uint32_t file) { current_ = file; }

  /// Adds a problem. Control characters in the texts become spaces. A problem with the same file,
  /// line, element and text is added once. With a line only, it belongs to the current file.
  void add(core::Origin at, std::string_view element, std::string_view text,
           core::FindingId id = core::FindingId::rule);
  void add(int line, std::string_view element, std::string_view text,
           core::FindingId id = core::FindingId::rule) {
    add(core::Origin{.file = current_, .line = line}, element, text, id);
  }

  [[nodiscard]] bool empty() const { return found_.empty(); }
  [[nodiscard]] std::size_t size() const { return found_.size(); }
  /// Whether problems were discarded because there are too many, so that the examination may end.
  [[nodiscard]] bool overflowing() const { return overflowing_; }
  /// The names of all files, by number.
  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

  /// Removes all problems and returns them in the order of files, then of lines.
  std::vector<Problem> take();

 private:
  struct Entry {
    core::Origin at;
    std::string element;
    std::string text;
    core::FindingId id;
  };
  [[nodiscard]] std::string name_of(std::uint32_t file) const {
    return file < files_.size() ? files_[file] : std::string();
  }

  std::vector<std::string> files_;
  std::uint32_t current_ = 0;
  std::vector<Entry> found_;
  bool overflowing_ = false;
};

}  // namespace mlcca::description
