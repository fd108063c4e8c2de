// SPDX-License-Identifier: BSD-2-Clause
#include "tools/escape.hpp"

#include "control/utf8.hpp"
#include "tools/table.hpp"

namespace mlcca::tools {
namespace {

constexpr std::size_t kMostOnALine = 1000;  // a Description in XML has 1024; the rest is room for a
                                            // character that is cut

}  // namespace

std::string escaped(std::string_view text, std::string_view apostrophe) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += apostrophe;
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string html_text(std::string_view text) { return escaped(printable(text), "&#39;"); }

std::string one_line(std::string_view from) {
  auto text = control::to_utf8(from);
  // U+FFFE and U+FFFF are not allowed in XML.
  for (const std::string_view none : {"\xef\xbf\xbe", "\xef\xbf\xbf"})
    for (auto at = text.find(none); at != std::string::npos; at = text.find(none))
      text.replace(at, none.size(), "?");
  std::string out;
  for (const char c : text) {
    const bool blank = static_cast<unsigned char>(c) <= ' ' || c == '\x7f';
    if (blank && (out.empty() || out.back() == ' ')) continue;
    out += blank ? ' ' : c;
  }
  while (out.ends_with(' ')) out.pop_back();
  if (out.size() <= kMostOnALine) return out;
  std::size_t end = kMostOnALine;
  while ((static_cast<unsigned char>(out[end]) & 0xc0U) == 0x80U) --end;
  out.resize(end);
  return out + "...";
}

std::string json_in_markup(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json)
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  return out;
}

std::string in_comment(std::string_view text) {
  auto out = one_line(text);
  for (auto at = out.find("--"); at != std::string::npos; at = out.find("--", at))
    out.replace(at, 2, "- -");
  return out.ends_with('-') ? out + ' ' : out;
}

}  // namespace mlcca::tools
