// SPDX-License-Identifier: BSD-2-Clause
// Checks the bytes of a document before the parser reads them, for what libxml2 does not handle
// well.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mlcca::description {

/// Rejects NUL, which libxml2 takes for the end, and start tags with too many attributes: libxml2
/// compares each with each, so that 10^6 of them take minutes. It follows comments, CDATA sections
/// and tags only as far as that needs. The parser stops at the first text that is not well-formed,
/// and so does the guard's count.
class Guard {
 public:
  /// Something that is wrong with the bytes, and the line in which it is.
  struct Wrong {
    int line = 0;
    std::string text;
  };
  /// Takes the next bytes. Returns the first thing that is wrong in them, or nullopt.
  std::optional<Wrong> take(std::string_view bytes);

  /// The line in which the open comment or CDATA section begins; 0 if none is open.
  [[nodiscard]] int open_since() const {
    return state_ == State::comment || state_ == State::section ? began_ : 0;
  }
  /// The line in which the first comment begins that contains "--"; 0 if none does.
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
  int began_ = 0;  ///< line of the latest "<!"
  int wrong_comment_ = 0;
  char quote_ = 0;              ///< quotation mark of the open value in a tag; 0: outside of values
  std::size_t attributes_ = 0;  ///< number of attributes of the open tag
  std::string start_;           ///< first characters of markup after "<!"
  std::uint32_t latest_ = 0;    ///< the last four characters, compared with the end of open markup
};

}  // namespace mlcca::description
