// SPDX-License-Identifier: BSD-2-Clause
// Integers in network byte order: the most significant octet comes first.
#pragma once
#include <array>
#include <cstdint>
#include <span>

namespace mlcca {

/// The integer that `octets` encode; there must be at most 8 of them.
constexpr std::uint64_t from_big_endian(std::span<const std::uint8_t> octets) {
  std::uint64_t out = 0;
  for (const std::uint8_t octet : octets) out = out << 8U | octet;
  return out;
}

/// The 8 octets of `number` in network byte order.
constexpr std::array<std::uint8_t, sizeof(std::uint64_t)> big_endian(std::uint64_t number) {
  std::array<std::uint8_t, sizeof number> out{};
  for (auto octet = out.rbegin(); octet != out.rend(); ++octet, number >>= 8U)
    *octet = static_cast<std::uint8_t>(number);
  return out;
}

}  // namespace mlcca
