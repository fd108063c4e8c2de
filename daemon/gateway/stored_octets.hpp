// SPDX-License-Identifier: BSD-2-Clause
// Digests and epochs as the journal has them: octets, and nothing where all of them are 0.
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

/// Of another length: zeros.
template <std::size_t N>
std::array<std::uint8_t, N> array_of(const std::string& from) {
  std::array<std::uint8_t, N> out{};
  if (from.size() == N)
    std::ranges::transform(from, out.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
  return out;
}

}  // namespace mlcca
