// SPDX-License-Identifier: BSD-2-Clause
// A text against XML and system.xsd, before it is edited and before it is written.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools::design {

/// Largest file that is edited.
inline constexpr std::size_t kMaxEdited = std::size_t{16} << 20U;

/// What is wrong with the text: "line 3: ...", nothing if it is well-formed UTF-8 without a DOCTYPE
/// and fits the schema. Opens no file and no connection; includes are not followed.
std::vector<std::string> problems_of_text(std::string_view text);

}  // namespace mlcca::tools::design
