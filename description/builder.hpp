// SPDX-License-Identifier: BSD-2-Clause
// Builds valid elements from the events of a parser.
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

/// A name in a namespace; the namespace is empty if there is none.
struct QualifiedName {
  std::string_view space;
  std::string_view local;
};

/// An attribute as the parser reports it.
struct ParsedAttribute {
  QualifiedName name;
  std::string_view value;
  int line = 0;  ///< line in which its value begins
};

/// Checks each event of a parser against the grammar, and builds the elements of a part of the
/// System as long as nothing is wrong. Their memory is reused for the next part, so that it is
/// bounded by the largest part.
class Builder {
 public:
  /// Called with the href at the end of each xi:include that is valid as far as the builder can
  /// see.
  using Include = std::function<void(std::string_view href, core::Origin at)>;

  Builder(Root root, Problems& problems, const Receiver& receiver, Include include);

  /// Events between these calls belong to that file, whose root becomes a child of the open
  /// element. end_file() discards elements that a syntax error has left open.
  void begin_file(std::uint32_t file);
  void end_file();

  /// `line`: where the start tag begins.
  void start(int line, const QualifiedName& name, std::span<const ParsedAttribute> attributes);
  /// `line`: where the piece of text ends.
  void text(int line, std::string_view piece);
  void end();

  /// Reports a problem. The part that is being built, if any, becomes invalid.
  void fail(core::Origin at, std::string_view element, std::string_view text, core::FindingId id);
  /// Reports a problem and ends the examination.
  void stop(core::Origin at, std::string_view element, std::string_view text, core::FindingId id);

  /// A file between these calls, after the end of the System, is read as if the System included it.
  void begin_parts();
  void end_parts();

  [[nodiscard]] bool valid() const { return valid_; }
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// The name of the innermost open element; empty if none is open.
  [[nodiscard]] std::string_view inside() const;

 private:
  /// An element whose end tag has not been read.
  struct Open {
    Open(const Child& child, core::Origin origin, std::size_t first)
        : type(child.type), name(child.name), at(origin), first_child(first) {}

    const ElementType* type;
    std::string_view name;
    core::Origin at;  ///< where its start tag is
    std::span<const KeyValue> attributes;
    std::size_t first_child;     ///< index of its first child in closed_
    Content content;             ///< which children it may still have
    bool wrong_content = false;  ///< already reported
    bool wrong_text = false;     ///< already reported
    bool has_base = false;       ///< it states xml:base
  };
  /// An xi:include whose end tag has not been read.
  struct OpenInclude {
    bool open = false;
    bool right = false;
    std::size_t depth = 0;  ///< number of open elements inside it
    core::Origin at;
    std::string href;
  };

  /// A file whose end has not been reached.
  struct OpenFile {
    std::uint32_t number = 0;
    std::size_t depth = 0;  ///< size of open_ where it began
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
  std::uint32_t file_ = 0;  ///< number of files_.back()
  std::vector<OpenFile> files_;
  std::vector<Open> open_;
  std::size_t skipped_ = 0;  ///< number of open elements that are not examined
  OpenInclude including_;
  std::string text_;  ///< text of the innermost element so far
  std::size_t items_ = 0;
  bool valid_ = true;
  bool part_valid_ = true;
  bool stopped_ = false;

  Arena memory_;
  std::vector<Element> closed_;  ///< the finished children of open elements
};

}  // namespace mlcca::description
