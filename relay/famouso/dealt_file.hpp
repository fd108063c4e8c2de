// SPDX-License-Identifier: BSD-2-Clause
// What a broker has dealt on one bus, kept over restarts: a line for each, written before the
// answer is sent.
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

class DealtFile {
 public:
  /// By UID or subject, in the order in which they were dealt.
  using All = std::vector<std::pair<std::uint64_t, std::uint16_t>>;

  /// Reads what is there; makes the file where there is none. What follows the last end of a line
  /// was not written whole, and was not answered: it is cut off. Errors: what is no such line, or
  /// deals a number again, with its number.
  static Result<DealtFile> open(const std::string& path);

  [[nodiscard]] const All& nodes() const { return nodes_; }
  [[nodiscard]] const All& tags() const { return tags_; }

  /// On disk afterwards, or an error, and then nothing of it counts.
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
