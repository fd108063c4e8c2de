// SPDX-License-Identifier: BSD-2-Clause
// What was meant, when a name is unknown: the known names, and the one that is close.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace mlcca::description {

/// The name that differs from `name` by a slip or two (letters added, lost, changed or swapped,
/// case aside), or an empty text. Looks at no more than the first 4096.
std::string_view closest(std::string_view name, std::span<const std::string_view> known);

/// "did you mean robot-can? Known are robot-can, second-can"; at most 9 are named.
std::string known_names(std::string_view name, std::span<const std::string_view> known);

}  // namespace mlcca::description
