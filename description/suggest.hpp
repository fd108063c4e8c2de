// SPDX-License-Identifier: BSD-2-Clause
// Suggestions for an unknown name: the known names, and the one that is similar.
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace mlcca::description {

/// The known name that differs from `name` by one or two slips (letters added, lost, changed or
/// swapped, ignoring case); empty if there is none. Only the first 4096 names are compared.
std::string_view closest(std::string_view name, std::span<const std::string_view> known);

/// The hint for an unknown name: "did you mean robot-can? Known are robot-can, second-can". At most
/// 9 names are listed.
std::string known_names(std::string_view name, std::span<const std::string_view> known);

}  // namespace mlcca::description
