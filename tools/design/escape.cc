// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/escape.hpp"

#include "tools/table.hpp"

namespace mlcca::tools::design {

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

}  // namespace mlcca::tools::design
