// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/variety.hpp"

#include <algorithm>

namespace mlcca::learn {
namespace {

/// The difference of each byte, without carry.
std::uint64_t difference(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t tops = 0x8080808080808080U;
  return ((a | tops) - (b & ~tops)) ^ ((a ^ ~b) & tops);
}

}  // namespace

void Variety::Steps::add(std::uint64_t step) {
  if (is_full()) return;
  const auto known = std::span(all).first(count);
  if (std::ranges::find(known, step) == known.end()) all[count++] = step;
}

void Variety::add(std::span<const std::uint8_t> data) {
  if (is_rich()) return;
  std::uint64_t now = 0;
  for (const std::uint8_t byte : data.first(std::min(data.size(), kBytes))) now = now << 8U | byte;
  const std::uint64_t before = last_;
  last_ = now;
  if (is_first_ || now == before) {
    is_first_ = false;
    return;
  }
  if (changes_ < kSeveral) ++changes_;
  sums_.add(difference(now, before));
  bits_.add(now ^ before);
}

}  // namespace mlcca::learn
