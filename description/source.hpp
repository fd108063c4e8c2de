// SPDX-License-Identifier: BSD-2-Clause
// Where the bytes of a document come from: a regular file, or a text in memory.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::description {

/// One document, read once from its start to its end.
class Source {
 public:
  /// Identity of a file, whatever its name.
  using Identity = std::pair<dev_t, ino_t>;

  /// A regular file. The error says why it cannot be opened or its start be read.
  static Result<Source> open(const std::string& path);
  /// `text` must outlive the source.
  explicit Source(std::string_view text) : left_(text), size_(text.size()) {}

  /// The first bytes, all of a text, that read() gives too. Before the first read().
  [[nodiscard]] std::string_view start() const { return left_; }
  /// Bytes when it was opened.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Nothing for a text.
  [[nodiscard]] const std::optional<Identity>& identity() const { return identity_; }

  /// Up to `size` bytes to `to`: how many, 0 at the end, -1 with errno.
  ssize_t read(char* to, std::size_t size);
  /// From now on `copy` is called with what read() gives; null: no more.
  void on_read(std::function<void(std::string_view)> copy) { copy_ = std::move(copy); }

 private:
  Source() = default;
  ssize_t fill();

  Fd fd_;
  std::unique_ptr<char[]> buffer_;  ///< of a file
  std::string_view left_;           ///< of the buffer or text, not yet given
  std::uint64_t size_ = 0;
  std::optional<Identity> identity_;
  std::function<void(std::string_view)> copy_;
};

/// Why a document that begins so, and is no longer than that if it is `whole`, cannot be UTF-8 XML;
/// or nothing.
std::optional<std::string> wrong_start(std::string_view xml, bool whole);

}  // namespace mlcca::description
