// SPDX-License-Identifier: BSD-2-Clause
// The page of cockpit/ with the present answers of mlccad, as one HTML file.
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace mlcca::tools {

/// `answers` are pairs of a verb's name and its JSON, made by to_json(). The page loads nothing
/// from elsewhere.
std::string report_page(const std::vector<std::pair<std::string, std::string>>& answers,
                        std::uint64_t taken_unix_ns);

}  // namespace mlcca::tools
