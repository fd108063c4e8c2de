// SPDX-License-Identifier: BSD-2-Clause
// An XML text with the byte positions of its elements. An edit replaces exact bytes, so that
// comments, blank lines and quotes stay as the author wrote them.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// The bytes from offset `from` up to but not including `to`.
struct Range {
  std::size_t from = 0;
  std::size_t to = 0;
  [[nodiscard]] bool empty() const { return from == to; }
};

/// An attribute of a start tag.
struct MarkupAttribute {
  std::string_view name;  ///< with its namespace prefix
  Range whole;            ///< name, equals sign and quoted value
  Range value;            ///< the value between the quotes
};

/// An element.
struct Node {
  std::string_view name;  ///< with its namespace prefix
  int line = 0;           ///< line of the first character of the start tag
  Range whole;
  Range start_tag;
  Range content;  ///< for an empty-element tag, empty and at the end of the tag
  bool has_end_tag = false;
  std::vector<MarkupAttribute> attributes;
  std::vector<Node> children;  ///< only elements

  /// The first child of that name, or nullptr.
  [[nodiscard]] const Node* child(std::string_view key) const;
  /// The attribute of that name, or nullptr.
  [[nodiscard]] const MarkupAttribute* attribute(std::string_view key) const;
};

/// Checks the beginning of a text: an error if it is not XML in UTF-8 or has a DOCTYPE. Must be
/// called before the text reaches a parser.
Result<void> check_prolog(std::string_view text);

/// A well-formed XML text in UTF-8 without DOCTYPE, and its elements. The nodes have views into the
/// text.
class Markup {
 public:
  explicit Markup(std::string text);
  Markup(const Markup&) = delete;
  Markup(Markup&&) = delete;
  Markup& operator=(const Markup&) = delete;
  Markup& operator=(Markup&&) = delete;
  ~Markup() = default;

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const Node& root() const { return root_; }

  /// Replaces the bytes of `range` and parses the text again: references to nodes become invalid.
  void replace(Range range, std::string_view by);

  [[nodiscard]] std::string_view view(Range range) const {
    return std::string_view(text_).substr(range.from, range.to - range.from);
  }
  /// The text of an element or the value of an attribute: references and CDATA are resolved,
  /// comments are left out, and white space is collapsed.
  [[nodiscard]] std::string text_of(const Node& node) const;
  [[nodiscard]] std::string text_of(const MarkupAttribute& attribute) const;
  /// The comments and processing instructions of an element, concatenated.
  [[nodiscard]] std::string comments_in(const Node& node) const;
  /// The line ending of the text.
  [[nodiscard]] std::string_view newline() const;

 private:
  std::string text_;
  Node root_;
};

}  // namespace mlcca::tools::design
