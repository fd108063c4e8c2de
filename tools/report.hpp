// SPDX-License-Identifier: BSD-2-Clause
// The page of cockpit/ with what mlccad says now, as one file.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::tools {

/// `answers`: the JSON of verbs by their names, as to_json() makes it. The file loads nothing.
std::string report_page(const std::vector<std::pair<std::string, std::string>>& answers,
                        std::uint64_t taken_unix_ns);

}  // namespace mlcca::tools
