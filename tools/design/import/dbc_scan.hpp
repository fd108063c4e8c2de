// SPDX-License-Identifier: BSD-2-Clause
// The words of a DBC file: an untrusted text that is read in one pass.
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
    text,  ///< what stood in quotes, without them
    mark,  ///< any other character
  };
  Kind kind = Kind::end;
  std::string_view text;  ///< of the file
  int line = 0;
  bool first = false;  ///< on its line

  [[nodiscard]] bool is(char mark) const {
    return kind == Kind::mark && text.size() == 1 && text.front() == mark;
  }
  [[nodiscard]] bool is_word(std::string_view word) const {
    return kind == Kind::word && text == word;
  }
};

/// What stood in quotes, where a quote has a backslash in front. Other backslashes stay: tools
/// write paths without a second one.
[[nodiscard]] std::string without_backslashes(std::string_view text);

/// What follows // up to the end of its line counts for nothing.
class DbcScanner {
 public:
  explicit DbcScanner(std::string_view text) : rest_(text) { advance(); }

  [[nodiscard]] const DbcToken& peek() const { return next_; }
  /// The line of peek() begins with a blank.
  [[nodiscard]] bool is_indented() const { return indented_; }
  DbcToken take();
  /// Up to the next token that is the first on its line.
  void skip_line();
  /// Up to and with the next semicolon that is in no text.
  void skip_statement();
  /// The lines that begin with a blank, which hold the names of a section NS_.
  void skip_indented();
  /// Line of quotes that are never closed; 0: there are none, as far as was read.
  [[nodiscard]] int unclosed() const { return unclosed_; }

 private:
  void advance();
  void skip_blanks();

  std::string_view rest_;
  DbcToken next_;
  int line_ = 1;
  int unclosed_ = 0;
  bool fresh_ = true;      ///< nothing of this line was taken yet
  bool indented_ = false;  ///< the line of next_ begins with a blank
};

}  // namespace mlcca::tools::design
