// SPDX-License-Identifier: BSD-2-Clause
// The file in which an application writes its handlers. What stands between its markers belongs to
// the user and survives: also when its channel is renamed or removed, at the end of the file.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "tools/design/generate/header.hpp"

namespace mlcca::tools::design {

/// The file as it is generated, with the user's code of `old`, the file as it is now. The error
/// says why `old` cannot be taken over: its markers do not match, or something was changed outside
/// of them; `force` gives such changes up.
Result<std::string> callbacks_of(const core::System& system, const Unit& unit,
                                 const std::vector<Callback>& callbacks,
                                 const std::optional<std::string>& old, bool force);

/// Names of regions whose code is kept at the end of the file, because nothing uses it any more.
std::vector<std::string> kept_regions(std::string_view text);

}  // namespace mlcca::tools::design
