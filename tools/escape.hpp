// SPDX-License-Identifier: BSD-2-Clause
// Text for XML and HTML: whatever it says, it stays text.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools {

/// Markup characters as references, for content and for attribute values in double or single
/// quotes.
std::string escaped(std::string_view text, std::string_view apostrophe = "&apos;");

/// The same for HTML, with control characters as '?'.
std::string html_text(std::string_view text);

/// One line of text in UTF-8: control characters become blanks, and it is cut between two
/// characters.
std::string one_line(std::string_view from);

/// JSON for within a <script> element. JSON has '<' in strings only, and there it becomes \u003c:
/// nothing that they say can end the element.
std::string json_in_markup(std::string_view json);

/// A line for within <!-- -->, where two hyphens would end it.
std::string in_comment(std::string_view text);

}  // namespace mlcca::tools
