// SPDX-License-Identifier: BSD-2-Clause
// Collects what is wrong with one file, in a form that is safe to print and bounded in size.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

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
  explicit Problems(std::string file) : file_(std::move(file)) {}

  /// Control characters in the texts become spaces. A repeated line, element and text is one
  /// problem.
  void add(int line, std::string_view element, std::string_view text);

  [[nodiscard]] bool empty() const { return found_.empty(); }
  [[nodiscard]] std::size_t size() const { return found_.size(); }
  /// Some were no longer kept: there is no point in looking for more.
  [[nodiscard]] bool overflowing() const { return overflowing_; }
  [[nodiscard]] const std::string& file() const { return file_; }

  /// All of them, ordered by line; leaves the collector empty.
  std::vector<Problem> take();

 private:
  std::string file_;
  std::vector<Problem> found_;
  bool overflowing_ = false;
};

}  // namespace mlcca::description
