// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/dbc_scan.hpp"

#include <algorithm>

#include "base/ascii.hpp"

namespace mlcca::tools::design {
namespace {

bool is_of_word(char c) {
  return is_of_name(c) || c == '+' || static_cast<unsigned char>(c) >= 0x80;
}

}  // namespace

std::string without_backslashes(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i)
    if (!text.substr(i).starts_with("\\\"")) out += text[i];
  return out;
}

DbcToken DbcScanner::take() {
  const auto taken = next_;
  advance();
  return taken;
}

void DbcScanner::skip_line() {
  while (next_.kind != DbcToken::Kind::end && !next_.first) advance();
}

void DbcScanner::skip_statement() {
  const auto goes_on = [&] {
    if (next_.first && next_.kind == DbcToken::Kind::word && next_.text.ends_with('_'))
      return false;  // a semicolon is missing
    return next_.kind != DbcToken::Kind::end && !next_.is(';');
  };
  while (goes_on()) advance();
  if (next_.is(';')) advance();
}

void DbcScanner::skip_indented() {
  while (next_.kind != DbcToken::Kind::end && (!next_.first || indented_)) advance();
}

void DbcScanner::skip_blanks() {
  while (!rest_.empty() &&
         (static_cast<unsigned char>(rest_.front()) <= ' ' || rest_.starts_with("//"))) {
    if (rest_.front() == '/') {
      rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size()));
      continue;
    }
    if (rest_.front() == '\n') {
      ++line_;
      fresh_ = true;
      indented_ = false;
    } else if (fresh_) {
      indented_ = true;
    }
    rest_.remove_prefix(1);
  }
}

void DbcScanner::advance() {
  skip_blanks();
  next_ = {.kind = DbcToken::Kind::end, .text = {}, .line = line_, .first = fresh_};
  fresh_ = false;
  if (rest_.empty()) return;
  if (rest_.front() == '"') {
    std::size_t end = 1;
    while (end < rest_.size() && rest_[end] != '"') end += rest_[end] == '\\' ? 2 : 1;
    if (end >= rest_.size()) {
      unclosed_ = line_;
      rest_ = {};
      return;
    }
    next_.kind = DbcToken::Kind::text;
    next_.text = rest_.substr(1, end - 1);
    line_ += static_cast<int>(std::ranges::count(next_.text, '\n'));
    rest_.remove_prefix(end + 1);
    return;
  }
  std::size_t size = 0;
  while (size < rest_.size() && is_of_word(rest_[size])) ++size;
  next_.kind = size > 0 ? DbcToken::Kind::word : DbcToken::Kind::mark;
  size = std::max<std::size_t>(size, 1);
  next_.text = rest_.substr(0, size);
  rest_.remove_prefix(size);
}

}  // namespace mlcca::tools::design
