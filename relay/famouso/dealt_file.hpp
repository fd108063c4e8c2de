// SPDX-License-Identifier: BSD-2-Clause
// The file in which a broker stores its assignments on one bus. It has a line for each:
//
//   node 0x7e 0x6d6c636361000001
//   tag 0x3fff 0x5355425343524942
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::relay {

/// Reads and extends the file of assignments. A line is written before the answer is sent, so that
/// an assignment that a node knows is never lost.
class DealtFile {
 public:
  /// Pairs of UID or subject and the number assigned to it, in the order of assignment.
  using All = std::vector<std::pair<std::uint64_t, std::uint16_t>>;

  /// Opens the file and reads it, or creates it. An incomplete last line is cut off: its request
  /// was not answered. Fails, with the number of the line, if a line is malformed or assigns a
  /// number twice.
  static Result<DealtFile> open(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const All& nodes() const { return nodes_; }
  [[nodiscard]] const All& tags() const { return tags_; }

  /// Stores an assignment. Afterwards it is on the disk; if that fails, nothing of it counts.
  [[nodiscard]] Result<void> add_node(std::uint64_t uid, std::uint16_t number);
  [[nodiscard]] Result<void> add_tag(std::uint64_t subject, std::uint16_t tag);

 private:
  DealtFile(Fd file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}
  [[nodiscard]] Result<void> read(std::string_view text);
  [[nodiscard]] Result<void> append(const std::string& line);

  Fd file_;
  std::string path_;
  std::uint64_t size_ = 0;
  All nodes_;
  All tags_;
};

}  // namespace mlcca::relay
