// SPDX-License-Identifier: BSD-2-Clause
// From the events of a parser to valid elements: each event is held against the grammar, and where
// nothing is wrong, elements are built in memory that is used again for the next part.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "description/arena.hpp"
#include "description/content.hpp"
#include "description/grammar.hpp"
#include "description/xml.hpp"

namespace mlcca::description {

/// A name in a namespace; no namespace is empty.
struct QualifiedName {
  std::string_view space;
  std::string_view local;
};

/// An attribute as the parser gives it.
struct ParsedAttribute {
  QualifiedName name;
  std::string_view value;
  int line = 0;  ///< where its value begins
};

class Builder {
 public:
  /// Called at the end of an xi:include that is right as far as it can be seen, with its href.
  using Include = std::function<void(std::string_view href, core::Origin at)>;

  Builder(Root root, Problems& problems, const Receiver& receiver, Include include);

  /// Between these two, events belong to that file; its root is a child of the element that is
  /// open. What a syntax error has left open is dropped at its end.
  void begin_file(std::uint32_t file);
  void end_file();

  /// `line` is where the start tag begins.
  void start(int line, const QualifiedName& name, std::span<const ParsedAttribute> attributes);
  /// A piece of text that ends in `line`.
  void text(int line, std::string_view piece);
  void end();

  /// Reports it. The part that was begun, if any, is not valid.
  void fail(core::Origin at, std::string_view element, std::string_view text, core::FindingId id);
  /// The same, and nothing more is examined.
  void stop(core::Origin at, std::string_view element, std::string_view text, core::FindingId id);

  /// Between these two, after the System has ended, a file is read as if the System included it.
  void begin_parts();
  void end_parts();

  [[nodiscard]] bool valid() const { return valid_; }
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// The innermost open element, or an empty name.
  [[nodiscard]] std::string_view inside() const;

 private:
  /// An element whose end has not come.
  struct Open {
    Open(const Child& child, core::Origin origin, std::size_t first)
        : type(child.type), name(child.name), at(origin), first_child(first) {}

    const ElementType* type;
    std::string_view name;
    core::Origin at;  ///< of its start tag
    std::span<const KeyValue> attributes;
    std::size_t first_child;     ///< in closed_
    Content content;             ///< how far its children have come
    bool wrong_content = false;  ///< said already
    bool wrong_text = false;     ///< said already
    bool has_base = false;       ///< states xml:base
  };
  /// An xi:include whose end has not come.
  struct OpenInclude {
    bool open = false;
    bool right = false;
    std::size_t depth = 0;  ///< of elements inside it
    core::Origin at;
    std::string href;
  };

  /// A file whose end has not come.
  struct OpenFile {
    std::uint32_t number = 0;
    std::size_t depth = 0;  ///< of open_ where it began
  };

  void wrong(int line, std::string_view element, std::string_view text);
  void wrong(const Open& open, std::string_view text);
  bool within_limits(int line, std::string_view name, std::size_t attributes);
  const Child* root_child(int line, const QualifiedName& name);
  const Child* next_child_of_open(int line, const QualifiedName& name);
  void add_keys(Open& open, std::span<const ParsedAttribute> attributes);
  std::string_view key_value(const Open& open, const ParsedAttribute& attribute, const Key& key);
  void start_include(int line, std::span<const ParsedAttribute> attributes);
  void end_include();
  void add_text(std::string_view piece);
  std::string_view kept_collapsed(std::string_view text);
  void close();

  Root root_;
  Problems& problems_;
  const Receiver& receiver_;
  Include include_;
  std::uint32_t file_ = 0;  ///< of files_.back()
  std::vector<OpenFile> files_;
  std::vector<Open> open_;
  std::size_t skipped_ = 0;  ///< open elements that are not examined
  OpenInclude including_;
  std::string text_;  ///< of the innermost element, as far as it has come
  std::size_t items_ = 0;
  bool valid_ = true;
  bool part_valid_ = true;
  bool stopped_ = false;

  Arena memory_;
  std::vector<Element> closed_;  ///< children of what is open
};

}  // namespace mlcca::description
