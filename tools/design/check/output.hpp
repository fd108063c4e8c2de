// SPDX-License-Identifier: BSD-2-Clause
// Writes a report to its destination.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// Writes the file `path` atomically: a reader sees the old content or the new. A device or pipe is
/// written directly.
Result<void> write_output(const std::string& path, std::string_view text);

/// Whether `path` is the same file as one of `files`, also under another name.
bool is_one_of(const std::string& path, const std::vector<std::string>& files);

}  // namespace mlcca::tools::design
