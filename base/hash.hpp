// SPDX-License-Identifier: BSD-2-Clause
// FNV-1a, 64 bits: the same on every machine, and no secret.
#pragma once
#include <cstdint>
#include <string_view>

namespace mlcca {

inline constexpr std::uint64_t kHashOfNothing = 0xcbf29ce484222325U;

/// Of what has the hash `so_far`, and behind it this octet.
[[nodiscard]] constexpr std::uint64_t hash_with(std::uint64_t so_far, std::uint8_t octet) {
  return (so_far ^ octet) * 0x100000001b3U;
}

[[nodiscard]] constexpr std::uint64_t hash_of(std::string_view text,
                                              std::uint64_t so_far = kHashOfNothing) {
  for (const char c : text) so_far = hash_with(so_far, static_cast<std::uint8_t>(c));
  return so_far;
}

}  // namespace mlcca
