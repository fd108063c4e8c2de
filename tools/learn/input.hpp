// SPDX-License-Identifier: BSD-2-Clause
// What a recording is read from, in one pass: bytes in memory, or what comes piece by piece, from a
// pipe or out of gzip. Of the latter no more is kept than a reader asks for at once.
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

class Input {
 public:
  /// Puts bytes there and says how many; 0: there are no more.
  using Pull = std::function<Result<std::size_t>(std::span<std::uint8_t>)>;
  explicit Input(Bytes bytes) : there_(bytes), ended_(true) {}
  explicit Input(Pull pull) : pull_(std::move(pull)) {}
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  Input(Input&&) = delete;
  Input& operator=(Input&&) = delete;
  ~Input() = default;

  /// What there is from an offset on: so many bytes at least, unless it ends before. Offsets do not
  /// go back: what is before one is forgotten. Valid until the next call.
  Bytes from(std::uint64_t offset, std::size_t least);
  /// Offsets are counted from so many bytes on. Before anything else.
  void begin_at(std::size_t bytes);

  /// Why it ended before its end.
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  void read(std::size_t least);
  Pull pull_;
  std::vector<std::uint8_t> buffer_;
  Bytes there_;                  ///< of the buffer, where there is one
  std::uint64_t forgotten_ = 0;  ///< bytes in front of these
  std::uint64_t begin_ = 0;
  bool ended_ = false;
  std::optional<Error> error_;
};

/// It begins as gzip does (RFC 1952).
[[nodiscard]] bool is_gzip(Input& input);

/// What gzip has packed, of one file or several behind each other. `packed` must stay.
class Gunzip {
 public:
  explicit Gunzip(Input& packed);
  Gunzip(const Gunzip&) = delete;
  Gunzip& operator=(const Gunzip&) = delete;
  Gunzip(Gunzip&&) = delete;
  Gunzip& operator=(Gunzip&&) = delete;
  ~Gunzip();

  Result<std::size_t> pull(std::span<std::uint8_t> to);
  /// It ended within what was packed, or something else follows; empty: neither.
  [[nodiscard]] const std::string& remark() const { return remark_; }

 private:
  struct Stream;
  /// False: nothing follows that is packed.
  bool begin_next();
  Input& packed_;
  std::unique_ptr<Stream> stream_;
  std::uint64_t offset_ = 0;  ///< of what was unpacked
  bool ended_ = false;
  bool damaged_ = false;
  std::string remark_;
};

}  // namespace mlcca::learn
