// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/generate/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "base/ascii.hpp"

namespace mlcca::tools::design {
namespace {

/// Lower-case words that generated code must not use as identifiers: keywords up to C++23, macros
/// of common compilers and headers, and the namespaces that generated code uses.
constexpr auto kReserved = std::to_array<std::string_view>(
    {"alignas",       "alignof",     "and",       "and_eq",    "asm",          "assert",
     "auto",          "avr",         "bitand",    "bitor",     "bool",         "break",
     "case",          "catch",       "char",      "char16_t",  "char32_t",     "char8_t",
     "class",         "co_await",    "co_return", "co_yield",  "compl",        "concept",
     "const",         "consteval",   "constexpr", "constinit", "continue",     "decltype",
     "default",       "delete",      "do",        "double",    "else",         "enum",
     "errno",         "explicit",    "export",    "extern",    "false",        "final",
     "float",         "for",         "friend",    "goto",      "if",           "import",
     "inline",        "int",         "linux",     "long",      "main",         "mlcca",
     "module",        "mutable",     "namespace", "new",       "noexcept",     "not",
     "not_eq",        "nullptr",     "operator",  "or",        "or_eq",        "override",
     "peer",          "private",     "protected", "public",    "register",     "reinterpret_cast",
     "requires",      "return",      "short",     "signed",    "sizeof",       "static",
     "static_assert", "static_cast", "std",       "stderr",    "stdin",        "stdout",
     "struct",        "switch",      "template",  "this",      "thread_local", "throw",
     "true",          "try",         "typedef",   "typeid",    "typename",     "union",
     "unix",          "unsigned",    "using",     "virtual",   "void",         "volatile",
     "wchar_t",       "while",       "xor",       "xor_eq",    "checks",       "const_cast",
     "dynamic_cast",  "i386"});

char small(char c) { return is_large_letter(c) ? static_cast<char>(c + 32) : c; }
char large(char c) { return is_small_letter(c) ? static_cast<char>(c - 32) : c; }

/// "CAN" becomes "Can": words in capitals have the form of macros.
std::string capitalised(std::string word) {
  const bool shouted = word.size() > 1 && std::ranges::all_of(word, [](char c) {
                         return is_large_letter(c) || is_digit(c);
                       });
  if (shouted) std::ranges::transform(word, word.begin(), small);
  word.front() = large(word.front());
  return word;
}

/// The number of bytes of the UTF-8 character that begins with `c`.
std::size_t length_of(unsigned char c) {
  if (c < 0x80) return 1;
  if (c < 0xe0) return 2;
  return c < 0xf0 ? 3 : 4;
}

/// Whether the character changes the direction of text, so that a person would read something else
/// than the compiler.
bool turns_direction(std::string_view character) {
  if (!character.starts_with("\xe2\x80") && !character.starts_with("\xe2\x81")) return false;
  const auto last = static_cast<unsigned char>(character.back());
  return character[1] == '\x81' ? last >= 0xa6 && last <= 0xa9
                                : (last >= 0xaa && last <= 0xae) || last == 0x8e || last == 0x8f;
}

}  // namespace

std::string type_name(std::string_view name) {
  std::string out;
  if (name.starts_with("0x") || name.starts_with("0X")) {
    // A channel without a name, or an end of one: "0xa4ef@bus".
    const auto end = std::min(name.find_first_not_of("0123456789abcdefABCDEF", 2), name.size());
    std::string digits(name.substr(2, end - 2));
    std::ranges::transform(digits, digits.begin(), small);
    out = "Subject_" + digits;
    name.remove_prefix(end);
  }
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) out += capitalised(word);
    word.clear();
  };
  for (const char c : name) {
    if (is_alphanumeric(c))
      word += c;
    else
      end_word();
  }
  end_word();
  if (out.empty() || is_digit(out.front())) out.insert(out.begin(), 'N');
  return out;
}

std::string file_name(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (is_alphanumeric(c))
      out += small(c);
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (out.ends_with('_')) out.pop_back();
  if (out.empty() || is_digit(out.front())) out.insert(out.begin(), 'n');
  return out;
}

std::string small_name(std::string_view name) {
  auto out = file_name(name);
  // Types of the C library end in _t, such as size_t and uint8_t in generated code.
  if (out.ends_with("_t") || std::ranges::find(kReserved, out) != kReserved.end()) out += '_';
  return out;
}

std::string comment_text(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const auto size = std::min(length_of(static_cast<unsigned char>(text.front())), text.size());
    const auto character = text.substr(0, size);
    const auto c = static_cast<unsigned char>(character.front());
    if (c < 0x20 || c == 0x7f || turns_direction(character))
      out += ' ';
    else if (c == '\\' || (c == '?' && out.ends_with('?')))
      out += c == '\\' ? '/' : '.';
    else
      out += character;
    text.remove_prefix(size);
  }
  return out + "\"";
}

std::string string_literal(std::string_view text) {
  auto out = comment_text(text);
  // Quotes within the text would end the literal.
  std::replace(out.begin() + 1, out.end() - 1, '"', '\'');
  return out;
}

std::string Names::take(const std::string& wanted) {
  const auto folded = [](std::string name) {
    std::ranges::transform(name, name.begin(), small);
    return name;
  };
  if (taken_.insert(folded(wanted)).second) return wanted;
  int& number = next_.try_emplace(folded(wanted), 2).first->second;
  std::string name;
  do {
    name = fmt::format("{}{}{}", wanted, wanted.ends_with('_') ? "" : "_", number++);
  } while (!taken_.insert(folded(name)).second);
  return name;
}

}  // namespace mlcca::tools::design
