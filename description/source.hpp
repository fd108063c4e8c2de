// SPDX-License-Identifier: BSD-2-Clause
// The source of a document: a regular file, or a text in memory.
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

/// One document, which is read once from the start to the end.
class Source {
 public:
  /// Identifies a file independently of its name.
  using Identity = std::pair<dev_t, ino_t>;

  /// Opens a regular file. Fails with the reason if it cannot be opened or its first bytes cannot
  /// be read.
  static Result<Source> open(const std::string& path);
  /// `text` must outlive the source.
  explicit Source(std::string_view text) : left_(text), size_(text.size()) {}

  /// The first bytes (all bytes of a text), which read() will return as well. Valid before the
  /// first read().
  [[nodiscard]] std::string_view start() const { return left_; }
  /// The size in bytes when it was opened.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Nullopt for a text.
  [[nodiscard]] const std::optional<Identity>& identity() const { return identity_; }

  /// Copies up to `size` bytes to `to`. Returns their number, 0 at the end, or -1 with errno.
  ssize_t read(char* to, std::size_t size);
  /// Sets a function that is called with all bytes that read() returns; null removes it.
  void on_read(std::function<void(std::string_view)> copy) { copy_ = std::move(copy); }

 private:
  Source() = default;
  ssize_t fill();

  Fd fd_;
  std::unique_ptr<char[]> buffer_;  ///< for a file only
  std::string_view left_;           ///< the part of the buffer or text that is not read yet
  std::uint64_t size_ = 0;
  std::optional<Identity> identity_;
  std::function<void(std::string_view)> copy_;
};

/// Why a document with these first bytes cannot be XML in UTF-8; nullopt if it can. `whole`: these
/// are all of its bytes.
std::optional<std::string> wrong_start(std::string_view xml, bool whole);

}  // namespace mlcca::description
