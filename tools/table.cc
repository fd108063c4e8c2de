// SPDX-License-Identifier: BSD-2-Clause
// Widths are counted in UTF-8 characters; padding is never coloured.
#include "tools/table.hpp"

#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <utility>

namespace mlcca::tools {
namespace {

std::string_view code(Style style) {
  switch (style) {
    case Style::plain:
      return "";
    case Style::bold:
      return "1";
    case Style::dim:
      return "2";
    case Style::good:
      return "32";
    case Style::bad:
      return "1;31";
    case Style::warning:
      return "1;33";
  }
  return "";
}

std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; }));
}

}  // namespace

Color color_of(int fd, bool forbidden) {
  const char* no_color = std::getenv("NO_COLOR");  // NOLINT(concurrency-mt-unsafe)
  const char* terminal = std::getenv("TERM");      // NOLINT(concurrency-mt-unsafe)
  const bool dumb = terminal != nullptr && std::string_view(terminal) == "dumb";
  const bool asked_not_to = forbidden || (no_color != nullptr && *no_color != '\0');
  return asked_not_to || dumb || ::isatty(fd) == 0 ? Color::no : Color::yes;
}

std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    // The control characters of C1 are 0xc2 0x80 to 0xc2 0x9f in UTF-8.
    const bool c1 =
        c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    result.push_back(c < 0x20 || c == 0x7f || c1 ? '?' : text[i]);
    if (c1) ++i;
  }
  return result;
}

std::string styled(std::string_view text, Style style, Color color) {
  auto clean = printable(text);
  if (color == Color::no || style == Style::plain || clean.empty()) return clean;
  return "\x1b[" + std::string(code(style)) + "m" + clean + "\x1b[0m";
}

void TextTable::add(std::vector<Cell> row) {
  assert(row.size() == columns_.size());
  for (auto& cell : row) cell.text = printable(cell.text);
  rows_.push_back(std::move(row));
}

std::string TextTable::text(Color color, std::string_view indent) const {
  std::vector<std::size_t> shown;
  std::vector<std::size_t> widths(columns_.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    for (const auto& row : rows_) widths[i] = std::max(widths[i], width(row[i].text));
    if (widths[i] == 0) continue;
    widths[i] = std::max(widths[i], width(columns_[i].title));
    shown.push_back(i);
  }
  std::string result;
  const auto line = [&](auto cell_of) {
    std::string text(indent);
    std::size_t gap = 0;  // written only before the next text, so that no line ends with blanks
    for (const auto i : shown) {
      const Cell cell = cell_of(i);
      const std::size_t padding = widths[i] - width(cell.text);
      if (columns_[i].align == Align::right) gap += padding;
      if (!cell.text.empty()) {
        text.append(std::exchange(gap, 0), ' ');
        text += styled(cell.text, cell.style, color);
      }
      if (columns_[i].align == Align::left) gap += padding;
      gap += 2;
    }
    result += text + '\n';
  };
  if (shown.empty()) return result;
  line([&](std::size_t i) { return Cell{std::string(columns_[i].title), Style::bold}; });
  for (const auto& row : rows_) line([&](std::size_t i) { return row[i]; });
  return result;
}

}  // namespace mlcca::tools
