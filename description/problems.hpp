// SPDX-License-Identifier: BSD-2-Clause
// Collects what is wrong with the files of a description, in a form that is safe to print and
// bounded in size.
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

/// More problems than this are not kept.
inline constexpr std::size_t kMaxProblems = 1000;

/// Longest text of a problem in bytes; the rest is cut. Nobody reads more, and a hostile file must
/// not make our answer larger than itself.
inline constexpr std::size_t kMaxProblemText = 480;

/// The text, or as many whole UTF-8 characters of it as fit into `bytes` and then an ellipsis.
std::string clipped(std::string_view text, std::size_t bytes);

class Problems {
 public:
  /// `file` is the first one, number 0, and the current one.
  explicit Problems(std::string file) : files_{std::move(file)} {}

  /// The number of that file: its own if it is known, else the next one.
  std::uint32_t add_file(const std::string& file);
  /// The file that a problem without an origin is in from now on: a number of add_file.
  void set_file(std::uint32_t file) { current_ = file; }

  /// Control characters in the texts become spaces. A repeated file, line, element and text is one
  /// problem. Without an origin, the line is one of the current file.
  void add(core::Origin at, std::string_view element, std::string_view text,
           core::FindingId id = core::FindingId::rule);
  void add(int line, std::string_view element, std::string_view text,
           core::FindingId id = core::FindingId::rule) {
    add(core::Origin{.file = current_, .line = line}, element, text, id);
  }

  [[nodiscard]] bool empty() const { return found_.empty(); }
  [[nodiscard]] std::size_t size() const { return found_.size(); }
  /// Some were no longer kept: there is no point in looking for more.
  [[nodiscard]] bool overflowing() const { return overflowing_; }
  /// All files, by number.
  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

  /// All of them, ordered by file in the order of the numbers, then by line; leaves the collector
  /// without any.
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
