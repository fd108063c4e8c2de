// SPDX-License-Identifier: BSD-2-Clause
// Where the elements of an XML text stand, to the byte: an edit replaces these bytes and no others,
// so that comments, blank lines and quotes stay as their author wrote them.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace mlcca::tools::design {

/// Bytes from `from` up to, not including, `to`.
struct Range {
  std::size_t from = 0;
  std::size_t to = 0;
  [[nodiscard]] bool empty() const { return from == to; }
};

struct MarkupAttribute {
  std::string_view name;  ///< with its prefix
  Range whole;            ///< name, equals sign and quoted value
  Range value;            ///< between the quotes
};

struct Node {
  std::string_view name;  ///< with its prefix
  int line = 0;           ///< of the start tag's first character
  Range whole;
  Range start_tag;
  Range content;  ///< empty at the end of an empty-element tag
  bool has_end_tag = false;
  std::vector<MarkupAttribute> attributes;
  std::vector<Node> children;  ///< elements only

  /// The first child of that name, or null.
  [[nodiscard]] const Node* child(std::string_view key) const;
  /// The attribute of that name, or null.
  [[nodiscard]] const MarkupAttribute* attribute(std::string_view key) const;
};

/// Why the text cannot be edited, as far as its beginning shows: not XML in UTF-8, or with a
/// DOCTYPE. To be asked before any parser sees it.
Result<void> check_prolog(std::string_view text);

/// A well-formed XML text in UTF-8 without a DOCTYPE; the views in its nodes refer to it.
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

  /// Replaces these bytes. All nodes are found again: earlier references are invalid.
  void replace(Range range, std::string_view by);

  [[nodiscard]] std::string_view view(Range range) const {
    return std::string_view(text_).substr(range.from, range.to - range.from);
  }
  /// The characters of an element: references and CDATA resolved, comments left out, white space
  /// collapsed.
  [[nodiscard]] std::string text_of(const Node& node) const;
  [[nodiscard]] std::string text_of(const MarkupAttribute& attribute) const;
  /// The comments and processing instructions of an element, one behind the other.
  [[nodiscard]] std::string comments_in(const Node& node) const;
  /// What a line of this text ends with.
  [[nodiscard]] std::string_view newline() const;

 private:
  std::string text_;
  Node root_;
};

}  // namespace mlcca::tools::design
