// SPDX-License-Identifier: BSD-2-Clause
// Counts with the singular or plural form of the noun, for output.
#pragma once
#include <concepts>
#include <string>
#include <string_view>

namespace mlcca {

/// "1 frame" or "3 frames". `several` is the plural where it is not `one` with an s ("3 entries").
template <std::integral Number>
[[nodiscard]] std::string many(Number n, std::string_view one, std::string_view several = {}) {
  std::string out = std::to_string(n) + ' ';
  if (n == 1) return out += one;
  if (!several.empty()) return out += several;
  out += one;
  return out += 's';
}

}  // namespace mlcca
