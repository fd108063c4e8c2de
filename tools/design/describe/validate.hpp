// SPDX-License-Identifier: BSD-2-Clause
// Validates a text against XML and system.xsd, before it is edited and before it is written.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools::design {

/// Largest file that is edited, in bytes.
inline constexpr std::size_t kMaxEdited = std::size_t{16} << 20U;

/// The problems of a text ("line 3: ..."); empty if it is well-formed UTF-8 without DOCTYPE and
/// valid by the schema. Opens no file and no connection, and does not follow includes.
std::vector<std::string> problems_of_text(std::string_view text);

}  // namespace mlcca::tools::design
