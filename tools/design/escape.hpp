// SPDX-License-Identifier: BSD-2-Clause
// Text for XML and HTML: whatever it says, it stays text.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools::design {

/// Markup characters as references, for content and for attribute values in double or single
/// quotes.
std::string escaped(std::string_view text, std::string_view apostrophe = "&apos;");

/// The same for HTML, with control characters as '?'.
std::string html_text(std::string_view text);

}  // namespace mlcca::tools::design
