// SPDX-License-Identifier: BSD-2-Clause
// An arena for many small objects that are discarded together, again and again.
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

/// Allocates memory from blocks, which it keeps for reuse. No destructor is called, so only
/// trivially destructible types are allowed.
class Arena {
 public:
  /// Uninitialised memory for `count` objects of T, valid until reset().
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

  /// Makes all memory available again; everything allocated before becomes invalid.
  void reset() {
    block_ = 0;
    used_ = 0;
  }

 private:
  struct Block {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size;
  };

  /// Continues with the next block of at least `bytes`, and makes one if none is left.
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
  std::size_t block_ = 0;  ///< index of the block in use
  std::size_t used_ = 0;   ///< bytes of that block in use
};

}  // namespace mlcca::description
