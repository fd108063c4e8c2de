// SPDX-License-Identifier: BSD-2-Clause
// Escaping of text for XML and HTML, so that no content can become markup.
#pragma once
#include <string>
#include <string_view>

namespace mlcca::tools {

/// Replaces the characters of markup by references, for content and for attribute values in double
/// or single quotes.
std::string escaped(std::string_view text, std::string_view apostrophe = "&apos;");

/// As escaped(), for HTML: control characters become '?'.
std::string html_text(std::string_view text);

/// One line of valid UTF-8: control characters become blanks, and a long text is cut between two
/// characters.
std::string one_line(std::string_view from);

/// JSON for the inside of a <script> element. '<' occurs only in strings of JSON and becomes
/// \u003c, so no string can end the element.
std::string json_in_markup(std::string_view json);

/// A line for the inside of <!-- -->, where two hyphens would end the comment.
std::string in_comment(std::string_view text);

}  // namespace mlcca::tools
