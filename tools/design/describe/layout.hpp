// SPDX-License-Identifier: BSD-2-Clause
// Inserts and removes elements in an XML text, with the layout of their neighbours.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "tools/design/describe/markup.hpp"

namespace mlcca::tools::design {

/// An element to be written, with either a text or children.
struct NewElement {
  std::string name;
  std::string text;
  std::vector<NewElement> children;
  std::string attributes;  ///< the attributes as in the tag, with a leading space
};

/// Where the line with offset `at` begins, and the blanks at its beginning.
std::size_t line_start(std::string_view text, std::size_t at);
std::string indentation(std::string_view text, std::size_t at);

/// Whether only blanks precede offset `at` on its line.
bool begins_line(std::string_view text, std::size_t at);

/// The blanks by which a child is indented more than its parent in this file.
std::string step(const Markup& markup);

/// The XML of the element. `indent` is a line break with the blanks behind it; without a line break
/// the element is written on one line. `step` is the further indentation of children.
std::string written(const NewElement& element, const std::string& indent, const std::string& step);

/// Inserts the element behind `sibling`, or behind a comment that follows it on the same line.
void insert_after(Markup& markup, const Node& sibling, const NewElement& element);

/// Inserts the element as the first child of `parent`.
void insert_first(Markup& markup, const Node& parent, const NewElement& element);

/// Removes the element, and its line if nothing else is on it.
void remove(Markup& markup, const Node& node);

/// Replaces the text of an element without children; surrounding white space stays.
void replace_text(Markup& markup, const Node& node, std::string_view text);

/// Sets an attribute of a tag, appends it if it is not there, or removes it if `value` is empty.
void set_attribute(Markup& markup, const Node& node, std::string_view name, std::string_view value);

}  // namespace mlcca::tools::design
