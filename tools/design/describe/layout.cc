// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/layout.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tools/escape.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kBlank = " \t";

}  // namespace

std::size_t line_start(std::string_view text, std::size_t at) {
  const auto newline = text.substr(0, at).rfind('\n');
  return newline == std::string_view::npos ? 0 : newline + 1;
}

std::string indentation(std::string_view text, std::size_t at) {
  const auto start = line_start(text, at);
  const auto end = std::min(text.find_first_not_of(kBlank, start), text.size());
  return std::string(text.substr(start, end - start));
}

bool begins_line(std::string_view text, std::size_t at) {
  const auto start = line_start(text, at);
  return text.substr(start, at - start).find_first_not_of(kBlank) == std::string_view::npos;
}

std::string step(const Markup& markup) {
  const auto& text = markup.text();
  const auto& root = markup.root();
  if (!root.children.empty() && begins_line(text, root.children.front().whole.from)) {
    const auto outer = indentation(text, root.whole.from);
    const auto inner = indentation(text, root.children.front().whole.from);
    if (inner.size() > outer.size() && inner.starts_with(outer)) return inner.substr(outer.size());
  }
  return "  ";
}

namespace {

bool has_grandchildren(const NewElement& element) {
  return std::ranges::any_of(element.children,
                             [](const NewElement& child) { return !child.children.empty(); });
}

std::string on_one_line(const NewElement& element) {
  if (element.text.empty() && element.children.empty())
    return fmt::format("<{}{}/>", element.name, element.attributes);
  std::string inside = escaped(element.text);
  for (const auto& child : element.children) inside += on_one_line(child);
  return fmt::format("<{0}{1}>{2}</{0}>", element.name, element.attributes, inside);
}

/// Whether each child gets its own line: in lists, and in attributes with a unit. A unit is one
/// line.
bool needs_lines(const NewElement& element) {
  return (element.name == "Attributes" && !element.children.empty()) ||
         (element.name == "Attribute" && has_grandchildren(element));
}

}  // namespace

std::string written(const NewElement& element, const std::string& indent, const std::string& step) {
  if (!needs_lines(element) || !indent.contains('\n')) return on_one_line(element);
  std::string out = fmt::format("<{}{}>", element.name, element.attributes);
  for (const auto& child : element.children)
    out += indent + step + written(child, indent + step, step);
  return out + indent + fmt::format("</{}>", element.name);
}

namespace {

/// The position behind comments that follow on the same line, if nothing else follows there.
std::size_t after_comments(std::string_view text, std::size_t at) {
  for (auto end = at;;) {
    end = std::min(text.find_first_not_of(kBlank, end), text.size());
    if (end == text.size()) return at;
    if (text[end] == '\n' || text[end] == '\r') return end;
    if (!text.substr(end).starts_with("<!--")) return at;
    const auto close = text.find("-->", end);
    if (close == std::string_view::npos) return at;
    end = close + 3;
    if (text.substr(at, end - at).contains('\n')) return at;
  }
}

}  // namespace

void insert_after(Markup& markup, const Node& sibling, const NewElement& element) {
  const std::string_view text = markup.text();
  std::string before;
  std::size_t at = sibling.whole.to;
  if (begins_line(text, sibling.whole.from)) {
    before = std::string(markup.newline()) + indentation(text, sibling.whole.from);
    at = after_comments(text, at);
  }
  markup.replace({at, at}, before + written(element, before, step(markup)));
}

void insert_first(Markup& markup, const Node& parent, const NewElement& element) {
  const std::string_view text = markup.text();
  const bool lines = begins_line(text, parent.whole.from) && text.contains('\n');
  const auto outer =
      lines ? std::string(markup.newline()) + indentation(text, parent.whole.from) : "";
  const auto inner = lines ? outer + step(markup) : "";
  const auto child = inner + written(element, inner, step(markup));
  if (!parent.has_end_tag) {
    const auto slash = text.substr(0, parent.start_tag.to).rfind('/');
    markup.replace({slash, parent.start_tag.to},
                   fmt::format(">{}{}</{}>", child, outer, std::string(parent.name)));
    return;
  }
  const auto content = markup.view(parent.content);
  if (content.find_first_not_of(kSpace) == std::string_view::npos)
    markup.replace(parent.content, child + outer);
  else
    markup.replace({parent.content.from, parent.content.from}, child);
}

void remove(Markup& markup, const Node& node) {
  const std::string_view text = markup.text();
  auto range = node.whole;
  const auto after = std::min(text.find_first_not_of(kBlank, range.to), text.size());
  const auto newline = text.find('\n', range.to);
  const bool ends_line = after == text.size() || text[after] == '\n' || text[after] == '\r';
  if (begins_line(text, range.from) && ends_line && newline != std::string_view::npos)
    range = {line_start(text, range.from), newline + 1};
  markup.replace(range, "");
}

void replace_text(Markup& markup, const Node& node, std::string_view text) {
  if (!node.has_end_tag) {
    const auto tag = markup.view(node.start_tag);
    const auto open = std::string(tag.substr(0, tag.rfind('/')));
    markup.replace(node.whole,
                   fmt::format("{}>{}</{}>", open, escaped(text), std::string(node.name)));
    return;
  }
  auto range = node.content;
  const auto content = markup.view(range);
  const auto first = std::min(content.find_first_not_of(kSpace), content.size());
  if (content.contains('<')) {
    markup.replace(
        range, std::string(content.substr(0, first)) + escaped(text) + markup.comments_in(node));
    return;
  }
  range.to -= content.size() - (content.find_last_not_of(kSpace) + 1);
  range.from = std::min(range.from + first, range.to);
  markup.replace(range, escaped(text));
}

void set_attribute(Markup& markup, const Node& node, std::string_view name,
                   std::string_view value) {
  const std::string_view text = markup.text();
  if (const auto* found = node.attribute(name)) {
    if (!value.empty()) {
      markup.replace(found->value, escaped(value));
      return;
    }
    auto range = found->whole;
    while (range.from > 0 && kSpace.contains(text[range.from - 1])) --range.from;
    markup.replace(range, "");
    return;
  }
  if (value.empty()) return;
  const auto at = node.attributes.empty() ? node.start_tag.from + 1 + node.name.size()
                                          : node.attributes.back().whole.to;
  markup.replace({at, at}, fmt::format(" {}=\"{}\"", name, escaped(value)));
}

}  // namespace mlcca::tools::design
