// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/describe/markup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/number.hpp"
#include "description/source.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool is_space(char c) { return kSpace.contains(c); }

/// The end of a comment, processing instruction or CDATA section that begins at `at`; otherwise
/// `at`.
std::size_t after_skipped(std::string_view text, std::size_t at) {
  struct Kind {
    std::string_view open;
    std::string_view close;
  };
  for (const Kind kind : {Kind{"<!--", "-->"}, Kind{"<?", "?>"}, Kind{"<![CDATA[", "]]>"}}) {
    if (!text.substr(at).starts_with(kind.open)) continue;
    const auto close = text.find(kind.close, at + kind.open.size());
    return close == std::string_view::npos ? text.size() : close + kind.close.size();
  }
  return at;
}

/// Finds the elements of a well-formed text. It never reads behind the end, even if the text is not
/// well-formed.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  Node root() {
    std::vector<Node> open;
    Node root;
    while (at_ < text_.size()) {
      const auto next = std::min(text_.find('<', at_), text_.size());
      advance(next);
      if (next == text_.size()) break;
      if (const auto skipped = after_skipped(text_, at_); skipped != at_) {
        advance(skipped);
      } else if (text_.substr(at_).starts_with("</")) {
        if (open.empty()) break;
        end_tag(open.back());
        close(open, root);
      } else {
        open.push_back(start_tag());
        if (!open.back().has_end_tag) close(open, root);
      }
    }
    return root;
  }

 private:
  static void close(std::vector<Node>& open, Node& root) {
    Node done = std::move(open.back());
    open.pop_back();
    if (open.empty())
      root = std::move(done);
    else
      open.back().children.push_back(std::move(done));
  }

  void advance(std::size_t to) {
    line_ += static_cast<int>(std::ranges::count(text_.substr(at_, to - at_), '\n'));
    at_ = to;
  }
  void skip_space() { advance(std::min(text_.find_first_not_of(kSpace, at_), text_.size())); }
  std::string_view name() {
    const auto end = std::min(text_.find_first_of(" \t\r\n/>=", at_), text_.size());
    const auto result = text_.substr(at_, end - at_);
    advance(end);
    return result;
  }

  Node start_tag() {
    Node node;
    node.line = line_;
    node.start_tag.from = node.whole.from = at_;
    advance(at_ + 1);
    node.name = name();
    for (skip_space(); at_ < text_.size() && text_[at_] != '>' && text_[at_] != '/'; skip_space())
      node.attributes.push_back(attribute());
    node.has_end_tag = at_ < text_.size() && text_[at_] == '>';
    advance(std::min(at_ + (node.has_end_tag ? 1 : 2), text_.size()));
    node.start_tag.to = node.whole.to = at_;
    node.content = {at_, at_};
    return node;
  }

  MarkupAttribute attribute() {
    MarkupAttribute result;
    result.whole.from = at_;
    result.name = name();
    skip_space();
    advance(std::min(at_ + 1, text_.size()));  // the equals sign
    skip_space();
    const char quote = at_ < text_.size() ? text_[at_] : '"';
    const auto from = std::min(at_ + 1, text_.size());
    const auto to = std::min(text_.find(quote, from), text_.size());
    result.value = {from, to};
    advance(std::min(to + 1, text_.size()));
    result.whole.to = at_;
    return result;
  }

  void end_tag(Node& node) {
    node.content.to = at_;
    const auto end = text_.find('>', at_);
    advance(end == std::string_view::npos ? text_.size() : end + 1);
    node.whole.to = at_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

void append_utf8(std::string& out, std::uint32_t c) {
  const auto tail = [&](unsigned shift) {
    out += static_cast<char>(0x80U | ((c >> shift) & 0x3fU));
  };
  if (c < 0x80) {
    out += static_cast<char>(c);
  } else if (c < 0x800) {
    out += static_cast<char>(0xc0U | (c >> 6U));
    tail(0);
  } else if (c < 0x10000) {
    out += static_cast<char>(0xe0U | (c >> 12U));
    tail(6);
    tail(0);
  } else {
    out += static_cast<char>(0xf0U | (c >> 18U));
    tail(12);
    tail(6);
    tail(0);
  }
}

/// Appends the character that "&name;" stands for.
void append_reference(std::string& out, std::string_view name) {
  constexpr std::pair<std::string_view, char> named[] = {
      {"lt", '<'}, {"gt", '>'}, {"amp", '&'}, {"quot", '"'}, {"apos", '\''}};
  for (const auto& [known, character] : named)
    if (name == known) out += character;
  if (!name.starts_with('#')) return;
  name.remove_prefix(1);
  const bool hex = name.starts_with('x');
  if (hex) name.remove_prefix(1);
  const int base = hex ? kHexadecimalBase : kDecimalBase;
  append_utf8(out, number_in<std::uint32_t>(name, base).value_or(0));
}

std::string resolved(std::string_view raw) {
  std::string out;
  while (!raw.empty()) {
    const auto end = raw.front() == '&' ? raw.find(';') : std::string_view::npos;
    if (end == std::string_view::npos) {
      out += raw.front();
      raw.remove_prefix(1);
    } else {
      append_reference(out, raw.substr(1, end - 1));
      raw.remove_prefix(end + 1);
    }
  }
  return out;
}

std::string collapsed(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (!is_space(c))
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  }
  if (out.ends_with(' ')) out.pop_back();
  return out;
}

/// The content of a CDATA section; empty for other markup.
std::string_view inside_cdata(std::string_view piece) {
  if (!piece.starts_with("<![CDATA[")) return {};
  piece.remove_prefix(9);
  return piece.substr(0, piece.size() - std::min<std::size_t>(piece.size(), 3));
}

}  // namespace

const Node* Node::child(std::string_view key) const {
  const auto found = std::ranges::find(children, key, &Node::name);
  return found == children.end() ? nullptr : &*found;
}

const MarkupAttribute* Node::attribute(std::string_view key) const {
  const auto found = std::ranges::find(attributes, key, &MarkupAttribute::name);
  return found == attributes.end() ? nullptr : &*found;
}

Result<void> check_prolog(std::string_view text) {
  if (auto wrong = description::wrong_start(text, true)) return fail(std::move(*wrong));
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (text.contains('\0')) return fail("this is not XML in UTF-8: it holds a zero byte");
  for (std::size_t at = 0;;) {
    at = text.find_first_not_of(kSpace, at);
    if (at == std::string_view::npos) return fail("there is no element in it");
    if (text[at] != '<') return fail("this is not XML: the first character must be '<'");
    if (text.substr(at).starts_with("<!DOCTYPE"))
      return fail("a DOCTYPE is refused, and entities with it: remove it");
    const auto next = after_skipped(text, at);
    if (next == at) return {};
    at = next;
  }
}

Markup::Markup(std::string text) : text_(std::move(text)), root_(Scanner(text_).root()) {}

void Markup::replace(Range range, std::string_view by) {
  text_.replace(range.from, range.to - range.from, by);
  root_ = Scanner(text_).root();
}

std::string Markup::text_of(const Node& node) const {
  const auto content = view(node.content);
  std::string out;
  for (std::size_t at = 0; at < content.size();) {
    const auto next = std::min(content.find('<', at), content.size());
    out += resolved(content.substr(at, next - at));
    at = next;
    if (at == content.size()) break;
    auto end = after_skipped(content, at);
    if (end == at) end = std::min(content.find('>', at), content.size() - 1) + 1;
    out += inside_cdata(content.substr(at, end - at));
    at = end;
  }
  return collapsed(out);
}

std::string Markup::text_of(const MarkupAttribute& attribute) const {
  return collapsed(resolved(view(attribute.value)));
}

std::string Markup::comments_in(const Node& node) const {
  const auto content = view(node.content);
  std::string out;
  for (auto at = content.find('<'); at != std::string_view::npos; at = content.find('<', at)) {
    const auto end = after_skipped(content, at);
    const auto piece = content.substr(at, end - at);
    if (inside_cdata(piece).empty()) out += piece;
    at = std::max(end, at + 1);
  }
  return out;
}

std::string_view Markup::newline() const {
  const auto at = text_.find('\n');
  return at != std::string::npos && at > 0 && text_[at - 1] == '\r' ? "\r\n" : "\n";
}

}  // namespace mlcca::tools::design
