// SPDX-License-Identifier: BSD-2-Clause
// The content is moved to the front only if that frees at least half of the buffer; otherwise the
// buffer is doubled. So each byte is moved a bounded number of times.
#include "control/buffer.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

namespace mlcca::control {

std::span<char> Buffer::space(std::size_t at_least) {
  if (capacity_ - end_ < at_least) {
    const std::size_t held = end_ - begin_;
    if (held > capacity_ / 2 || capacity_ - held < at_least) {
      const std::size_t wanted = std::max(2 * capacity_, held + at_least);
      auto larger = std::make_unique_for_overwrite<char[]>(wanted);
      if (held != 0) std::memcpy(larger.get(), bytes_.get() + begin_, held);
      bytes_ = std::move(larger);
      capacity_ = wanted;
    } else if (held != 0) {
      std::memmove(bytes_.get(), bytes_.get() + begin_, held);
    }
    begin_ = 0;
    end_ = held;
  }
  return {bytes_.get() + end_, capacity_ - end_};
}

void Buffer::commit(std::size_t n) {
  assert(n <= capacity_ - end_);
  end_ += n;
}

void Buffer::append(std::string_view bytes) {
  if (bytes.empty()) return;
  std::memcpy(space(bytes.size()).data(), bytes.data(), bytes.size());
  commit(bytes.size());
}

void Buffer::consume(std::size_t n) {
  assert(n <= end_ - begin_);
  begin_ += n;
  if (begin_ == end_) begin_ = end_ = 0;
}

}  // namespace mlcca::control
