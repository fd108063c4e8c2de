// SPDX-License-Identifier: BSD-2-Clause
// Looks at the bytes of a document before the parser does, for what the library cannot bear.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::description {

/// Follows comments, sections and tags no further than to count the attributes of a start tag: the
/// library compares each with each, so that 10^6 of them take minutes, and it takes a NUL for the
/// end. The parser stops at the first thing that is not well-formed, and so does what is counted.
class Guard {
 public:
  struct Wrong {
    int line = 0;
    std::string text;
  };
  /// The next bytes. What is wrong in them, the first of it; or nothing.
  std::optional<Wrong> take(std::string_view bytes);

  /// Line in which the comment or section begins that is open now; 0: none is.
  [[nodiscard]] int open_since() const {
    return state_ == State::comment || state_ == State::section ? began_ : 0;
  }
  /// Line in which the first comment begins that holds "--"; 0: none has.
  [[nodiscard]] int wrong_comment() const { return wrong_comment_; }

 private:
  enum class State : std::uint8_t { text, opened, bang, comment, section, instruction, tag, other };

  bool take(char c);
  void begin(char c);
  void open_markup(char c);
  void in_tag(char c);
  void in_comment(char c);
  void until(std::string_view end, char c);

  State state_ = State::text;
  int line_ = 1;
  int began_ = 0;  ///< line of the latest <!
  int wrong_comment_ = 0;
  char quote_ = 0;              ///< of the value in a tag; 0: outside
  std::size_t attributes_ = 0;  ///< of the tag
  std::string start_;           ///< of markup that begins with <!
  std::uint32_t latest_ = 0;    ///< the last characters, which may end what is open
};

}  // namespace mlcca::description
