// SPDX-License-Identifier: BSD-2-Clause
#include "description/guard.hpp"

#include <fmt/format.h>

#include "description/xml.hpp"

namespace mlcca::description {

std::optional<Guard::Wrong> Guard::take(std::string_view bytes) {
  for (const char c : bytes) {
    if (c == '\n') ++line_;
    if (c == '\0')
      return Wrong{line_, "not well-formed XML: a NUL byte is no character; save the file as text"};
    if (!take(c))
      return Wrong{line_, fmt::format("an element has more than {} attributes; that is the limit",
                                      kMaxAttributes)};
  }
  return std::nullopt;
}

/// Returns false if the character begins one attribute too many.
bool Guard::take(char c) {
  switch (state_) {
    case State::text:
      if (c == '<') state_ = State::opened;
      break;
    case State::opened:
      begin(c);
      break;
    case State::bang:
      open_markup(c);
      break;
    case State::comment:
      in_comment(c);
      break;
    case State::section:
      until("]]>", c);
      break;
    case State::instruction:
      until("?>", c);
      break;
    case State::tag:
      in_tag(c);
      break;
    case State::other:
      if (c == '>') state_ = State::text;
      break;
  }
  return attributes_ <= kMaxAttributes;
}

void Guard::begin(char c) {
  latest_ = 0;
  start_.clear();
  attributes_ = 0;
  quote_ = 0;
  if (c == '!') {
    state_ = State::bang;
    began_ = line_;
  } else if (c == '?') {
    state_ = State::instruction;
  } else {
    state_ = c == '/' ? State::other : State::tag;
  }
}

/// Markup that begins with <! and is neither a comment nor a CDATA section is left to the parser,
/// which refuses it.
void Guard::open_markup(char c) {
  start_ += c;
  if (start_ == "--")
    state_ = State::comment;
  else if (start_ == "[CDATA[")
    state_ = State::section;
  else if (!std::string_view("--").starts_with(start_) &&
           !std::string_view("[CDATA[").starts_with(start_))
    state_ = State::other;
}

void Guard::in_tag(char c) {
  if (quote_ != 0) {
    if (c == quote_) quote_ = 0;
  } else if (c == '"' || c == '\'') {
    quote_ = c;
  } else if (c == '=') {
    ++attributes_;
  } else if (c == '>') {
    state_ = State::text;
  }
}

/// "--" may occur in a comment only as a part of the "-->" that ends it.
void Guard::in_comment(char c) {
  if ((latest_ & 0xffffU) == 0x2d2dU && c != '>' && wrong_comment_ == 0) wrong_comment_ = began_;
  until("-->", c);
}

void Guard::until(std::string_view end, char c) {
  latest_ = (latest_ << 8U) | static_cast<unsigned char>(c);
  std::uint32_t wanted = 0;
  std::uint32_t mask = 0;
  for (const char e : end) {
    wanted = (wanted << 8U) | static_cast<unsigned char>(e);
    mask = (mask << 8U) | 0xffU;
  }
  if ((latest_ & mask) == wanted) state_ = State::text;
}

}  // namespace mlcca::description
