// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <string>
#include <vector>

#include "core/result.hpp"

namespace mlcca::enforce {

/// For a daemon that cannot command the gates, because there is no bpffs: puts closed ones in the
/// place of all that are in this network namespace, where they stay until a daemon replaces them.
/// Gives the names of those interfaces.
Result<std::vector<std::string>> close_unpinned();

}  // namespace mlcca::enforce
