// SPDX-License-Identifier: BSD-2-Clause
// Text for HTML: whatever a description says, it stays text.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// For content and for attribute values in double or single quotes: markup characters as
/// references, control characters as '?'.
std::string html_text(std::string_view text);

}  // namespace mlcca::tools::design
