// SPDX-License-Identifier: BSD-2-Clause
// Splits a DBC file, which is untrusted text, into tokens in one pass.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace mlcca::tools::design {

struct DbcToken {
  enum class Kind : std::uint8_t {
    end,
    word,  ///< a keyword, a name or a number
    text,  ///< a text in quotes, without the quotes
    mark,  ///< any other character
  };
  Kind kind = Kind::end;
  std::string_view text;  ///< a part of the file
  int line = 0;
  bool first = false;  ///< it is the first token of its line

  [[nodiscard]] bool is(char mark) const {
    return kind == Kind::mark && text.size() == 1 && text.front() == mark;
  }
  [[nodiscard]] bool is_word(std::string_view word) const {
    return kind == Kind::word && text == word;
  }
};

/// The content of a text in quotes, with `\"` replaced by a quote. Other backslashes stay, because
/// tools write paths with single ones.
[[nodiscard]] std::string without_backslashes(std::string_view text);

/// The tokens of a text. Comments (// to the end of the line) are skipped.
class DbcScanner {
 public:
  explicit DbcScanner(std::string_view text) : rest_(text) { advance(); }

  [[nodiscard]] const DbcToken& peek() const { return next_; }
  /// Whether the line of peek() begins with a blank.
  [[nodiscard]] bool is_indented() const { return indented_; }
  DbcToken take();
  /// Skips everything up to the next token that is the first of its line.
  void skip_line();
  /// Skips everything up to and including the next semicolon outside of quotes.
  void skip_statement();
  /// Skips lines that begin with a blank; they have the names of a section NS_.
  void skip_indented();
  /// The line of a quote that is never closed; 0 if none was found yet.
  [[nodiscard]] int unclosed() const { return unclosed_; }

 private:
  void advance();
  void skip_blanks();

  std::string_view rest_;
  DbcToken next_;
  int line_ = 1;
  int unclosed_ = 0;
  bool fresh_ = true;      ///< no token of this line was taken yet
  bool indented_ = false;  ///< the line of next_ begins with a blank
};

}  // namespace mlcca::tools::design
