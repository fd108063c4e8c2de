// SPDX-License-Identifier: BSD-2-Clause
// Where a report goes.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// To the file `path`: whoever opens it sees the old content or the new. A device or pipe is
/// written as it is.
Result<void> write_output(const std::string& path, std::string_view text);

/// Whether `path` is the same file as one of `files`, whatever its name.
bool is_one_of(const std::string& path, const std::vector<std::string>& files);

}  // namespace mlcca::tools::design
