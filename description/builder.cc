// SPDX-License-Identifier: BSD-2-Clause
// The open elements are in open_. The finished children of all open elements are in closed_, one
// after another, until their parent ends and takes them.
#include "description/builder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "description/include.hpp"

namespace mlcca::description {
namespace {

constexpr std::string_view kIncludeSpace = "http://www.w3.org/2001/XInclude";
constexpr std::string_view kXmlSpace = "http://www.w3.org/XML/1998/namespace";
constexpr std::string_view kSchemaSpace = "http://www.w3.org/2001/XMLSchema-instance";

using core::FindingId;

constexpr bool is_space(char c) {
  return c <= ' ' && (c == ' ' || c == '\t' || c == '\n' || c == '\r');
}

bool is_blank(std::string_view text) { return std::ranges::all_of(text, is_space); }

/// Whether the text has no white space at its ends, and only single spaces inside.
bool is_collapsed(std::string_view text) {
  bool after_space = true;
  for (const char c : text) {
    if (is_space(c) && (c != ' ' || after_space)) return false;
    after_space = c == ' ';
  }
  return text.empty() || !after_space;
}

/// Whether the attribute is one that readers and editors may set on any element without changing
/// its meaning.
bool is_ignored(const ParsedAttribute& attribute) {
  if (attribute.name.space == kXmlSpace) return true;
  return attribute.name.space == kSchemaSpace &&
         attribute.name.local.ends_with("chemaLocation");  // also noNamespaceSchemaLocation
}

bool is_base(const ParsedAttribute& attribute) {
  return attribute.name.space == kXmlSpace && attribute.name.local == "base";
}

}  // namespace

Builder::Builder(Root root, Problems& problems, const Receiver& receiver, Include include)
    : root_(root), problems_(problems), receiver_(receiver), include_(std::move(include)) {}

void Builder::begin_file(std::uint32_t file) {
  files_.push_back({.number = file, .depth = open_.size()});
  file_ = file;
  problems_.set_file(file);
}

void Builder::end_file() {
  const auto depth = files_.back().depth;
  if (open_.size() > depth) {
    closed_.resize(open_[depth].first_child);
    open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(depth), open_.end());
  }
  skipped_ = 0;
  including_ = OpenInclude{};
  files_.pop_back();
  file_ = files_.empty() ? 0 : files_.back().number;
  problems_.set_file(file_);
}

void Builder::begin_parts() { open_.emplace_back(system_root(), core::Origin{}, 0); }

void Builder::end_parts() { open_.clear(); }

std::string_view Builder::inside() const {
  return open_.empty() ? std::string_view() : open_.back().name;
}

void Builder::fail(core::Origin at, std::string_view element, std::string_view text, FindingId id) {
  valid_ = false;
  part_valid_ = false;
  problems_.add(at, element, text, id);
  if (problems_.overflowing()) stopped_ = true;
}

void Builder::stop(core::Origin at, std::string_view element, std::string_view text, FindingId id) {
  fail(at, element, text, id);
  stopped_ = true;
}

void Builder::wrong(int line, std::string_view element, std::string_view text) {
  fail({.file = file_, .line = line}, element, text, FindingId::not_in_schema);
}

void Builder::wrong(const Open& open, std::string_view text) {
  fail(open.at, open.name, text, FindingId::not_in_schema);
}

bool Builder::within_limits(int line, std::string_view name, std::size_t attributes) {
  items_ += 1 + attributes;
  const core::Origin at{.file = file_, .line = line};
  if (items_ > kMaxItems)
    stop(at, name,
         fmt::format("the description has more than {} elements and attributes; that is the limit",
                     kMaxItems),
         FindingId::not_xml);
  else if (open_.size() + skipped_ >= kMaxDepth)
    stop(at, name, fmt::format("is nested deeper than {} elements; that is the limit", kMaxDepth),
         FindingId::not_xml);
  return !stopped_;
}

const Child* Builder::root_child(int line, const QualifiedName& name) {
  if (name.space.empty()) {
    if (name.local == system_root().name) return &system_root();
    const auto part = std::ranges::find(system_parts(), name.local, &Child::name);
    if (root_ == Root::system_or_part && part != system_parts().end()) return &*part;
  }
  stop({.file = file_, .line = line}, name.local,
       root_ == Root::system ? "the root element must be System, without a namespace"
                             : "the root element must be System or a part of one, without a "
                               "namespace",
       FindingId::not_in_schema);
  return nullptr;
}

const Child* Builder::next_child_of_open(int line, const QualifiedName& name) {
  auto& parent = open_.back();
  if (parent.wrong_content) return nullptr;
  if (name.space.empty())
    if (const auto* child = next_child(*parent.type, parent.content, name.local)) return child;
  parent.wrong_content = !is_container(*parent.type);
  if (!name.space.empty())
    wrong(line, name.local,
          fmt::format("is not known here: it is in the namespace {}, and no element of a "
                      "description is in one",
                      clipped(name.space, 80)));
  else if (open_.size() == files_.back().depth && name.local == system_root().name)
    wrong(line, name.local,
          "a System cannot be included: the root of an included file is a part of one");
  else
    wrong(line, name.local,
          explain_child(*parent.type, parent.content, parent.name, name.local,
                        std::span<const Element>(closed_).subspan(parent.first_child)));
  return nullptr;
}

void Builder::start(int line, const QualifiedName& name,
                    std::span<const ParsedAttribute> attributes) {
  if (!within_limits(line, name.local, attributes.size())) return;
  if (including_.open) {
    including_.right = false;
    if (++including_.depth == 1)
      wrong(line, name.local,
            "is not known here: xi:include is empty, and a file that is missing is an error");
    return;
  }
  if (skipped_ > 0) {
    ++skipped_;
    return;
  }
  if (open_.size() == 1) part_valid_ = true;
  if (name.space == kIncludeSpace && name.local == "include" && !open_.empty() &&
      !open_.back().wrong_content) {
    start_include(line, attributes);
    return;
  }
  const auto* child = open_.empty() ? root_child(line, name) : next_child_of_open(line, name);
  if (child == nullptr) {
    skipped_ = 1;
    return;
  }
  auto& open =
      open_.emplace_back(*child, core::Origin{.file = file_, .line = line}, closed_.size());
  text_.clear();
  add_keys(open, attributes);
  if (child == &system_root() && receiver_.root)
    receiver_.root({.name = open.name,
                    .line = line,
                    .file = file_,
                    .text = {},
                    .attributes = open.attributes,
                    .children = {},
                    .type = open.type});
}

void Builder::add_keys(Open& open, std::span<const ParsedAttribute> attributes) {
  const auto keys = open.type->keys;
  auto* const out = memory_.allocate<KeyValue>(attributes.size());
  std::size_t count = 0;
  std::uint64_t seen = 0;  // bit i: keys[i]
  for (const auto& attribute : attributes) {
    open.has_base = open.has_base || is_base(attribute);
    if (is_ignored(attribute)) continue;
    const auto key = std::ranges::find(keys, attribute.name.local, &Key::name);
    if (key == keys.end() || !attribute.name.space.empty()) {
      wrong(attribute.line, open.name, explain_key(*open.type, open.name, attribute.name.local));
      continue;
    }
    seen |= std::uint64_t{1} << static_cast<std::size_t>(key - keys.begin());
    const auto value = key_value(open, attribute, *key);
    std::construct_at(out + count, KeyValue{key->name, value});
    ++count;
  }
  open.attributes = {out, count};
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i].required && ((seen >> i) & 1U) == 0)
      wrong(open, fmt::format("attribute {} is missing", keys[i].name));
}

std::string_view Builder::key_value(const Open& open, const ParsedAttribute& attribute,
                                    const Key& key) {
  if (attribute.value.size() > kMaxValue) {
    stop(
        {.file = file_, .line = attribute.line}, open.name,
        fmt::format("attribute {} is longer than {} bytes; that is the limit", key.name, kMaxValue),
        FindingId::not_xml);
    return {};
  }
  const auto value = kept_collapsed(attribute.value);
  if (!is_valid(*key.type, value))
    wrong(attribute.line, open.name,
          fmt::format("attribute {}: {}", key.name, explain(*key.type, value)));
  return value;
}

void Builder::start_include(int line, std::span<const ParsedAttribute> attributes) {
  including_ = {.open = true, .right = true, .at = {.file = file_, .line = line}, .href = {}};
  const auto refuse_in = [&](int at, std::string_view text) {
    wrong(at, "include", text);
    including_.right = false;
  };
  const auto refuse = [&](std::string_view text) { refuse_in(line, text); };
  if (!is_container(*open_.back().type))
    refuse(fmt::format("xi:include is a child of {}: it stands for a whole part",
                       fmt::join(containers(), " or ")));
  if (std::ranges::any_of(open_, &Open::has_base) || std::ranges::any_of(attributes, is_base))
    refuse("is not read inside of xml:base: remove that, and give href relative to this file");
  bool has_href = false;
  for (const auto& attribute : attributes) {
    if (is_ignored(attribute)) continue;
    if (attribute.name.space.empty() && attribute.name.local == "href") {
      has_href = true;
      including_.href = clipped(attribute.value, kMaxHref);
      continue;
    }
    if (const auto text = explain_include_key(attribute.name.local, attribute.value); !text.empty())
      refuse_in(attribute.line, text);
  }
  if (!has_href) refuse("attribute href is missing: it names the file");
}

void Builder::end_include() {
  const auto include = std::exchange(including_, OpenInclude{});
  if (include.right) include_(include.href, include.at);
}

void Builder::text(int line, std::string_view piece) {
  if (skipped_ > 0 || open_.empty()) return;
  auto& open = open_.back();
  if (open.type->value != nullptr && !including_.open) {
    add_text(piece);
    return;
  }
  const bool blank = is_blank(piece);
  const bool closed = !including_.open && open.type->steps.empty();  // not even white space
  if (open.wrong_text || (blank && !closed)) return;
  open.wrong_text = true;
  if (blank) {
    wrong(open, "holds white space, which the schema does not allow in an empty element");
    return;
  }
  const auto* const first = std::ranges::find_if_not(piece, is_space);
  const auto after = std::count(first, piece.end(), '\n');
  wrong(line - static_cast<int>(after), including_.open ? "include" : open.name,
        "holds text, which has no meaning here: its content goes into elements");
}

void Builder::add_text(std::string_view piece) {
  // White space is collapsed at once, so that the text is bounded however much there is.
  if (text_.empty() && is_collapsed(piece)) {
    text_ = piece;
  } else {
    for (const char c : piece) {
      if (!is_space(c))
        text_ += c;
      else if (!text_.empty() && text_.back() != ' ')
        text_ += ' ';
    }
  }
  if (text_.size() <= kMaxValue) return;
  const auto& open = open_.back();
  stop(open.at, open.name, fmt::format("is longer than {} bytes; that is the limit", kMaxValue),
       FindingId::not_xml);
}

std::string_view Builder::kept_collapsed(std::string_view text) {
  if (is_collapsed(text)) return memory_.copy(text);
  auto* const out = memory_.allocate<char>(text.size());
  std::size_t size = 0;
  for (const char c : text) {
    if (!is_space(c))
      out[size++] = c;
    else if (size > 0 && out[size - 1] != ' ')
      out[size++] = ' ';
  }
  if (size > 0 && out[size - 1] == ' ') --size;
  return {out, size};
}

void Builder::end() {
  if (including_.open) {
    if (including_.depth > 0)
      --including_.depth;
    else
      end_include();
    return;
  }
  if (skipped_ > 0)
    --skipped_;
  else if (!open_.empty())  // empty after a limit has ended the examination
    close();
}

void Builder::close() {
  const auto& open = open_.back();
  Element element{.name = open.name,
                  .line = open.at.line,
                  .file = open.at.file,
                  .text = {},
                  .attributes = open.attributes,
                  .children = {},
                  .type = open.type};
  if (const auto* const type = open.type->value) {
    if (text_.ends_with(' ')) text_.pop_back();
    element.text = memory_.copy(text_);
    if (!open.wrong_content && !is_valid(*type, element.text))
      wrong(open, explain(*type, element.text));
  } else if (!open.wrong_content && !is_complete(*open.type, open.content)) {
    wrong(open, explain_incomplete(*open.type, open.content));
  }
  if (closed_.size() > open.first_child) {
    element.children = memory_.copy(std::span<const Element>(closed_).subspan(open.first_child));
    closed_.resize(open.first_child);
  }
  open_.pop_back();
  if (open_.size() > 1) {
    closed_.push_back(element);
  } else if (open_.size() == 1) {
    if (part_valid_ && receiver_.part) receiver_.part(element);
    memory_.reset();
  }
}

}  // namespace mlcca::description
