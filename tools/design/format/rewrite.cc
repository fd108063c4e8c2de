// SPDX-License-Identifier: BSD-2-Clause
// Replacements are collected and made in one pass: a file may have 100000 lists.
#include "tools/design/format/rewrite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "description/short_form.hpp"
#include "tools/design/describe/layout.hpp"
#include "tools/design/describe/lists.hpp"
#include "tools/design/describe/markup.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kWhite = " \t\r\n";
constexpr std::size_t kLineWidth = 100;  // columns of a line

bool is_blank(std::string_view text) {
  return text.find_first_not_of(kWhite) == std::string_view::npos;
}

/// Whether comments or processing instructions are between two elements, and where.
struct Between {
  bool behind = false;  ///< on the line on which the first element ends
  bool before = false;  ///< on later lines
};

Between comments_in_gap(std::string_view gap) {
  Between out;
  bool later = false;
  while (!gap.empty()) {
    const auto next = std::min(gap.find('<'), gap.size());
    later = later || gap.substr(0, next).contains('\n');
    gap.remove_prefix(next);
    if (gap.empty()) break;
    (later ? out.before : out.behind) = true;
    std::string_view end = gap[1] == '?' ? "?>" : "]]>";
    if (gap.starts_with("<!--")) end = "-->";
    const auto close = gap.find(end);
    gap.remove_prefix(close == std::string_view::npos ? gap.size() : close + end.size());
  }
  return out;
}

class Rewriter {
 public:
  explicit Rewriter(std::string text) : markup_(std::move(text)), step_(step(markup_)) {}

  Rewritten run(Form form) {
    visit(markup_.root(), form);
    const std::string_view text = markup_.text();
    std::size_t at = 0;
    for (const auto& [range, by] : edits_) {
      result_.text += text.substr(at, range.from - at);
      result_.text += by;
      at = range.to;
    }
    result_.text += text.substr(at);
    return std::move(result_);
  }

 private:
  struct Edit {
    Range range;
    std::string by;
  };

  void visit(const Node& node, Form form) {
    if (description::list_named(node.name) != nullptr) {
      if (form == Form::brief)
        shorten(node);
      else
        write_out(node);
      return;
    }
    for (const auto& child : node.children) visit(child, form);
  }

  // ---- conversion into the short form

  [[nodiscard]] bool is_dynamic(const Node& node) const {
    const auto* const found = node.attribute("dynamic");
    const auto text = found == nullptr ? std::string() : markup_.text_of(*found);
    return text == "true" || text == "1";
  }

  /// Why an attribute must stay an element; empty if it need not.
  [[nodiscard]] std::string_view obstacle(const Node& list, const Listed& listed,
                                          bool commented) const {
    const auto& node = *listed.element;
    if (commented || !markup_.comments_in(node).empty()) return "a comment stands with it";
    if (node.attribute("dynamic") != nullptr && is_dynamic(node) != is_dynamic(list))
      return "its dynamic is not that of the list";
    if (std::ranges::any_of(node.attributes,
                            [](const MarkupAttribute& a) { return a.name != "dynamic"; }))
      return "it has XML attributes of its own";
    return {};
  }

  /// The gaps around the children: before the first, between them, and behind the last.
  [[nodiscard]] static std::vector<Range> gaps_of(const Node& list) {
    std::vector<Range> out;
    auto from = list.content.from;
    for (const auto& child : list.children) {
      out.push_back({from, child.whole.from});
      from = child.whole.to;
    }
    out.push_back({from, list.content.to});
    return out;
  }

  void shorten(const Node& list) {
    const auto all = attributes_of(markup_, list);
    const auto gaps = gaps_of(list);
    std::vector<std::string> names;
    std::vector<std::string> added;
    std::vector<Edit> removed;
    bool empty = is_blank(markup_.view(gaps.back()));
    std::size_t child = 0;
    for (const auto& listed : all) {
      const auto& name = listed.quantity.name;
      if (listed.element == nullptr) {
        names.push_back(name);
        continue;
      }
      while (&list.children[child] != listed.element) ++child;
      const auto gap = gaps[child];
      const bool commented = comments_in_gap(markup_.view(gap)).before ||
                             comments_in_gap(markup_.view(gaps[child + 1])).behind;
      const auto value = short_if_possible(list, listed, commented, names);
      if (!value) {
        empty = false;
        continue;
      }
      names.push_back(name);
      added.push_back(fmt::format("{}=\"{}\"", short_name_of(name), *value));
      const auto white = markup_.view(gap).find_last_not_of(kWhite);
      const auto from = white == std::string_view::npos ? gap.from : gap.from + white + 1;
      empty = empty && from == gap.from;
      removed.push_back({{from, listed.element->whole.to}, {}});
    }
    if (added.empty()) return;
    result_.attributes += added.size();
    extend_tag(list, added, empty);
    if (empty)
      edits_.push_back({{list.start_tag.to - 1, list.whole.to}, "/>"});
    else
      std::ranges::move(removed, std::back_inserter(edits_));
  }

  std::optional<std::string> short_if_possible(const Node& list, const Listed& listed,
                                               bool commented,
                                               const std::vector<std::string>& names) {
    const auto& quantity = listed.quantity;
    if (!names_built_in(quantity.name)) return std::nullopt;
    auto why = obstacle(list, listed, commented);
    if (why.empty() && std::ranges::find(names, quantity.name) != names.end())
      why = "the list states it already";
    auto value = why.empty() ? short_value(list.name, quantity) : std::nullopt;
    if (value) return value;
    if (why.empty()) why = "the short form has no unit that says it exactly";
    result_.kept.push_back({listed.line, quantity.name, why});
    return std::nullopt;
  }

  /// Appends attributes to the start tag and breaks lines that become too long.
  void extend_tag(const Node& list, const std::vector<std::string>& added, bool closes) {
    const std::string_view text = markup_.text();
    const auto at = list.attributes.empty() ? list.start_tag.from + 1 + list.name.size()
                                            : list.attributes.back().whole.to;
    const auto first = list.start_tag.from + 1 + list.name.size() + 1;
    const auto start = line_start(text, list.start_tag.from);
    std::string aligned = indentation(text, list.start_tag.from);
    aligned.resize(std::max(aligned.size(), first - start), ' ');
    auto column = at - line_start(text, at);
    std::string by;
    for (const auto& one : added) {
      const auto end = closes && &one == &added.back() ? 2U : 1U;
      const bool alone = list.attributes.empty() && by.empty();
      if (!alone && column + 1 + one.size() + end > kLineWidth) {
        by += markup_.newline();
        by += aligned;
        by += one;
        column = aligned.size() + one.size();
      } else {
        by += ' ';
        by += one;
        column += 1 + one.size();
      }
    }
    edits_.push_back({{at, at}, by});
  }

  // ---- conversion into the paper's form

  void write_out(const Node& list) {
    const std::string_view text = markup_.text();
    const bool lines = begins_line(text, list.whole.from) && text.contains('\n');
    const auto outer =
        lines ? std::string(markup_.newline()) + indentation(text, list.whole.from) : std::string();
    const auto inner = lines ? inner_of(list, outer) : std::string();
    std::string elements;
    for (const auto& listed : attributes_of(markup_, list)) {
      if (listed.key == nullptr) continue;
      auto range = listed.key->whole;
      while (kWhite.contains(text[range.from - 1])) --range.from;
      edits_.push_back({range, {}});
      elements += inner + written(attribute_element(listed.quantity), inner, step_);
      ++result_.attributes;
    }
    if (elements.empty()) return;
    if (!list.has_end_tag) {
      auto slash = list.start_tag.to - 2;
      const auto last = list.attributes.back().whole.to;
      while (slash > last && kWhite.contains(text[slash - 1])) --slash;
      edits_.push_back(
          {{slash, list.start_tag.to}, fmt::format(">{}{}</{}>", elements, outer, list.name)});
      return;
    }
    if (is_blank(markup_.view(list.content))) {
      edits_.push_back({list.content, elements + outer});
      return;
    }
    const auto at = after_line_of_comments(list);
    edits_.push_back({{at, at}, elements});
  }

  /// The line break and indentation of the children of the list.
  [[nodiscard]] std::string inner_of(const Node& list, const std::string& outer) const {
    const std::string_view text = markup_.text();
    if (!list.children.empty() && begins_line(text, list.children.front().whole.from))
      return std::string(markup_.newline()) + indentation(text, list.children.front().whole.from);
    return outer + step_;
  }

  /// The beginning of the content of the list, behind comments on the line of the start tag.
  [[nodiscard]] std::size_t after_line_of_comments(const Node& list) const {
    auto at = list.content.from;
    for (;;) {
      const auto rest = markup_.view({at, list.content.to});
      const auto next = rest.find('<');
      if (next == std::string_view::npos || !rest.substr(next).starts_with("<!--") ||
          rest.substr(0, next).contains('\n'))
        return at;
      at += rest.find("-->", next) + 3;
    }
  }

  [[nodiscard]] static std::string short_name_of(std::string_view name) {
    for (std::size_t i = 0; i < kAttributes; ++i)
      if (name == kAttributeTable[i].name) return description::short_name(attribute_at(i));
    return {};
  }

  Markup markup_;
  std::string step_;
  std::vector<Edit> edits_;  ///< in the order of the text
  Rewritten result_;
};

}  // namespace

Rewritten rewritten(std::string text, Form form) { return Rewriter(std::move(text)).run(form); }

}  // namespace mlcca::tools::design
