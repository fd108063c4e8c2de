// SPDX-License-Identifier: BSD-2-Clause
// The hash FNV-1a of 64 bits. It is the same on every machine, so it may be stored; it resists no
// attacker who chooses the input.
#pragma once
#include <cstdint>
#include <string_view>

namespace mlcca {

inline constexpr std::uint64_t kHashOfNothing = 0xcbf29ce484222325U;

/// The hash of the octets that have the hash `so_far`, followed by `octet`.
[[nodiscard]] constexpr std::uint64_t hash_with(std::uint64_t so_far, std::uint8_t octet) {
  return (so_far ^ octet) * 0x100000001b3U;
}

[[nodiscard]] constexpr std::uint64_t hash_of(std::string_view text,
                                              std::uint64_t so_far = kHashOfNothing) {
  for (const char c : text) so_far = hash_with(so_far, static_cast<std::uint8_t>(c));
  return so_far;
}

}  // namespace mlcca
