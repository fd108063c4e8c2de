// SPDX-License-Identifier: BSD-2-Clause
// Memory for many small things that are dropped together and made again, over and over.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace mlcca::description {

/// Hands out memory from blocks that it keeps. Nothing is destroyed: only for types that need not
/// be.
class Arena {
 public:
  /// Uninitialized memory for `count` of T, until reset().
  template <class T>
  T* allocate(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>);
    static_assert(alignof(T) <= alignof(std::max_align_t));
    const std::size_t bytes = count * sizeof(T);
    used_ = (used_ + alignof(T) - 1) / alignof(T) * alignof(T);
    if (block_ == blocks_.size() || bytes > blocks_[block_].size - used_) next_block(bytes);
    void* const out = blocks_[block_].bytes.get() + used_;
    used_ += bytes;
    return static_cast<T*>(out);
  }

  std::string_view copy(std::string_view text) {
    if (text.empty()) return {};
    auto* const out = allocate<char>(text.size());
    std::memcpy(out, text.data(), text.size());
    return {out, text.size()};
  }

  template <class T>
  std::span<const T> copy(std::span<const T> from) {
    if (from.empty()) return {};
    auto* const out = allocate<T>(from.size());
    std::uninitialized_copy(from.begin(), from.end(), out);
    return {out, from.size()};
  }

  /// What was handed out may be handed out again.
  void reset() {
    block_ = 0;
    used_ = 0;
  }

 private:
  struct Block {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size;
  };

  /// Goes on to the next block that has `bytes`; makes one if there is none.
  void next_block(std::size_t bytes) {
    used_ = 0;
    if (block_ < blocks_.size()) ++block_;
    while (block_ < blocks_.size() && blocks_[block_].size < bytes) ++block_;
    if (block_ < blocks_.size()) return;
    const auto size = std::max(bytes, kSmallest);
    blocks_.push_back({std::make_unique_for_overwrite<std::byte[]>(size), size});
  }

  static constexpr std::size_t kSmallest = std::size_t{64} << 10U;  // bytes
  std::vector<Block> blocks_;
  std::size_t block_ = 0;  ///< that is handed out from
  std::size_t used_ = 0;   ///< of it
};

}  // namespace mlcca::description
