// SPDX-License-Identifier: BSD-2-Clause
// The file in which an application implements its handlers. The code between its markers belongs to
// the user and is always kept: if its channel is renamed or removed, at the end of the file.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/generate/header.hpp"

namespace mlcca::tools::design {

/// The new content of the file, with the user's code from `old`, its present content. An error if
/// the markers of `old` do not match or something outside of them was changed; `force` discards
/// such changes.
Result<std::string> callbacks_of(const core::System& system, const Unit& unit,
                                 const std::vector<Callback>& callbacks,
                                 const std::optional<std::string>& old, bool force);

/// The names of the regions at the end of a file that no handler uses any more.
std::vector<std::string> kept_regions(std::string_view text);

}  // namespace mlcca::tools::design
