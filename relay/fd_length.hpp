// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace mlcca::relay {

/// Length of a classic CAN frame with so many octets; nullopt above 8.
[[nodiscard]] constexpr std::optional<std::uint8_t> classic_length(std::size_t octets) {
  constexpr std::size_t most = 8;
  if (octets > most) return std::nullopt;
  return static_cast<std::uint8_t>(octets);
}

/// Length of the shortest CAN FD frame with room for so many octets; nullopt above 64.
[[nodiscard]] inline std::optional<std::uint8_t> fd_length(std::size_t octets) {
  constexpr std::size_t any = 8;  // up to here every length exists
  constexpr std::array<std::uint8_t, 7> lengths{12, 16, 20, 24, 32, 48, 64};
  if (octets <= any) return static_cast<std::uint8_t>(octets);
  const auto* const fits = std::ranges::find_if(lengths, [&](auto n) { return n >= octets; });
  return fits == lengths.end() ? std::nullopt : std::optional(*fits);
}

}  // namespace mlcca::relay
