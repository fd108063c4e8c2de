// SPDX-License-Identifier: BSD-2-Clause
// A number, and what is counted in the form that goes with it.
#pragma once
#include <concepts>
#include <string>
#include <string_view>

namespace mlcca {

/// "1 frame" or "3 frames"; `several`, where an s behind `one` is not the plural: "3 entries".
template <std::integral Number>
[[nodiscard]] std::string many(Number n, std::string_view one, std::string_view several = {}) {
  std::string out = std::to_string(n) + ' ';
  if (n == 1) return out += one;
  if (!several.empty()) return out += several;
  out += one;
  return out += 's';
}

}  // namespace mlcca
