// SPDX-License-Identifier: BSD-2-Clause
// The input of the readers of recordings.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"

namespace mlcca::learn {

using Bytes = std::span<const std::uint8_t>;

/// The bytes of a recording, which are read in one pass: from memory, or piece by piece from a pipe
/// or from gzip. In the second case no more is kept than a reader asks for at once.
class Input {
 public:
  /// Writes the next bytes to the span and returns their number; 0 at the end.
  using Pull = std::function<Result<std::size_t>(std::span<std::uint8_t>)>;
  explicit Input(Bytes bytes) : there_(bytes), ended_(true) {}
  explicit Input(Pull pull) : pull_(std::move(pull)) {}
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  Input(Input&&) = delete;
  Input& operator=(Input&&) = delete;
  ~Input() = default;

  /// The available bytes from `offset` on: at least `least`, unless the input ends before. Offsets
  /// must not decrease, because bytes before an offset are discarded. The result is valid until the
  /// next call.
  Bytes from(std::uint64_t offset, std::size_t least);
  /// Counts offsets from this number of bytes on. To be called before anything else.
  void begin_at(std::size_t bytes);

  /// The error because of which the input ended too early.
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  void read(std::size_t least);
  Pull pull_;
  std::vector<std::uint8_t> buffer_;
  Bytes there_;                  ///< a part of the buffer, if there is one
  std::uint64_t forgotten_ = 0;  ///< number of discarded bytes before `there_`
  std::uint64_t begin_ = 0;
  bool ended_ = false;
  std::optional<Error> error_;
};

/// Whether the input begins like gzip (RFC 1952).
[[nodiscard]] bool is_gzip(Input& input);

/// Decompresses gzip, also several members one after the other. `packed` must outlive this object.
class Gunzip {
 public:
  explicit Gunzip(Input& packed);
  Gunzip(const Gunzip&) = delete;
  Gunzip& operator=(const Gunzip&) = delete;
  Gunzip(Gunzip&&) = delete;
  Gunzip& operator=(Gunzip&&) = delete;
  ~Gunzip();

  Result<std::size_t> pull(std::span<std::uint8_t> to);
  /// Says that the compressed data ended too early, or that something else follows them; empty
  /// otherwise.
  [[nodiscard]] const std::string& remark() const { return remark_; }

 private:
  struct Stream;
  /// Begins the next member. False if none follows.
  bool begin_next();
  Input& packed_;
  std::unique_ptr<Stream> stream_;
  std::uint64_t offset_ = 0;  ///< offset in the compressed data
  bool ended_ = false;
  bool damaged_ = false;
  std::string remark_;
};

}  // namespace mlcca::learn
