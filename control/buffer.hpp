// SPDX-License-Identifier: BSD-2-Clause
// A buffer for bytes from a stream: read() into space(), then take messages off the front.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

namespace mlcca::control {

/// Grows with its content. The work for a message is linear in its size, no matter in how many
/// pieces it arrives.
///
///     auto room = buffer.space();
///     buffer.commit(read(fd, room.data(), room.size()));
///     for (;;) {
///       auto request = decode_request(buffer);
///       if (!request) return give_up(request.error());
///       if (!*request) break;  // wait for more
///       answer(**request);
///     }
class Buffer {
 public:
  /// A writable area of at least `at_least` bytes behind the content, valid until the next call of
  /// space().
  std::span<char> space(std::size_t at_least = 4096);

  /// Makes the first `n` bytes of space() part of the content.
  void commit(std::size_t n);

  /// Appends a copy of `bytes`.
  void append(std::string_view bytes);

  [[nodiscard]] std::string_view content() const { return {bytes_.get() + begin_, end_ - begin_}; }

  /// Removes `n` bytes from the front, or all if there are fewer.
  void consume(std::size_t n);

 private:
  std::unique_ptr<char[]> bytes_;
  std::size_t capacity_ = 0;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

}  // namespace mlcca::control
