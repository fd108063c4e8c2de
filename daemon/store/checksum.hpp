// SPDX-License-Identifier: BSD-2-Clause
// CRC-64/XZ: polynomial 0x42F0E1EBA9EA3693 (ECMA-182), reflected, initial value all ones, output
// inverted; its check value for "123456789" is 0x995DC9BBDF1939FA. Detects every single burst of up
// to 64 bits, and all but one in 2^64 of other damage. It does not protect against a program that
// may write the file.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace mlcca::store {

namespace detail {

constexpr std::array<std::uint64_t, 256> crc64_table() {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t byte = 0; byte < 256; ++byte) {
    std::uint64_t value = byte;
    for (int bit = 0; bit < 8; ++bit)
      value = (value >> 1U) ^ ((value & 1U) != 0 ? 0xc96c5795d7870f42U : 0U);
    table[byte] = value;
  }
  return table;
}
inline constexpr std::array<std::uint64_t, 256> kCrc64 = crc64_table();

}  // namespace detail

/// The checksum of `bytes` after what has the checksum `former` (0: nothing precedes).
constexpr std::uint64_t crc64(std::string_view bytes, std::uint64_t former = 0) {
  std::uint64_t value = ~former;
  for (const char c : bytes)
    value = (value >> 8U) ^ detail::kCrc64[(value ^ static_cast<unsigned char>(c)) & 0xffU];
  return ~value;
}
static_assert(crc64("123456789") == 0x995dc9bbdf1939faU);

}  // namespace mlcca::store
