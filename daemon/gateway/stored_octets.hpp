// SPDX-License-Identifier: BSD-2-Clause
// Conversion of digests and epochs to and from the strings of the journal. All zeros become an
// empty string.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace mlcca {

template <std::size_t N>
std::string octets_of(const std::array<std::uint8_t, N>& from) {
  const bool none = std::ranges::all_of(from, [](std::uint8_t octet) { return octet == 0; });
  return none ? std::string() : std::string(from.begin(), from.end());
}

/// Zeros if the string has another length.
template <std::size_t N>
std::array<std::uint8_t, N> array_of(const std::string& from) {
  std::array<std::uint8_t, N> out{};
  if (from.size() == N)
    std::ranges::transform(from, out.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
  return out;
}

}  // namespace mlcca
