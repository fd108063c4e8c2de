// SPDX-License-Identifier: BSD-2-Clause
// Elements put into a text and taken out of it the way their neighbours stand there.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "tools/design/describe/markup.hpp"

namespace mlcca::tools::design {

/// An element that is to be written: a text or children, not both.
struct NewElement {
  std::string name;
  std::string text;
  std::vector<NewElement> children;
  std::string attributes;  ///< as they stand in the tag, with the leading space
};

/// Where the line that `at` is on starts, and the blanks that it begins with.
std::size_t line_start(std::string_view text, std::size_t at);
std::string indentation(std::string_view text, std::size_t at);

/// Nothing but blanks stands before `at` on its line.
bool begins_line(std::string_view text, std::size_t at);

/// How much deeper a child stands than its parent.
std::string step(const Markup& markup);

/// The element as text. `indent` is the line break and the blanks before it; without a line break
/// in it, everything is one line.
std::string written(const NewElement& element, const std::string& indent, const std::string& step);

/// Puts the element behind `sibling`, and behind a comment that follows it on its line.
void insert_after(Markup& markup, const Node& sibling, const NewElement& element);

/// Puts the element into `parent`, as its first child element.
void insert_first(Markup& markup, const Node& parent, const NewElement& element);

/// Takes the element out, and its line if nothing else stands on it.
void remove(Markup& markup, const Node& node);

/// Replaces the text of an element that has no children; white space around it stays.
void replace_text(Markup& markup, const Node& node, std::string_view text);

/// Sets an attribute of the tag, adds it behind the others, or removes it if `value` is empty.
void set_attribute(Markup& markup, const Node& node, std::string_view name, std::string_view value);

}  // namespace mlcca::tools::design
