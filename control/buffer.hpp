// SPDX-License-Identifier: BSD-2-Clause
// Bytes on their way in from a stream: read() into space(), take messages off the front.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

namespace mlcca::control {

/// Grows with what it holds; the work for a message is linear in its size, in however many pieces
/// it arrives.
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
  /// Room for at least `at_least` bytes behind the content; valid until the next call of space().
  std::span<char> space(std::size_t at_least = 4096);

  /// The first `n` bytes of space() are content now.
  void commit(std::size_t n);

  /// space() and commit() of a copy.
  void append(std::string_view bytes);

  [[nodiscard]] std::string_view content() const { return {bytes_.get() + begin_, end_ - begin_}; }

  /// Drops `n` bytes, at most all, from the front.
  void consume(std::size_t n);

 private:
  std::unique_ptr<char[]> bytes_;
  std::size_t capacity_ = 0;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

}  // namespace mlcca::control
