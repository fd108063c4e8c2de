// SPDX-License-Identifier: BSD-2-Clause
// Text for a terminal: columns as wide as their content, colour where it is wanted.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools {

enum class Color : bool { no, yes };
enum class Style : std::uint8_t { plain, bold, dim, good, bad, warning };
enum class Align : std::uint8_t { left, right };

/// Colour on a terminal, unless it is forbidden here, by NO_COLOR or by a dumb TERM.
Color color_of(int fd, bool forbidden);

/// `text` with each control character as '?', so that no name or alias can steer the terminal.
std::string printable(std::string_view text);

/// printable() text in the colour of `style`.
std::string styled(std::string_view text, Style style, Color color);

struct Cell {
  std::string text;
  Style style = Style::plain;
};

struct Column {
  std::string_view title;
  Align align = Align::left;
};

class Table {
 public:
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// One cell for each column.
  void add(std::vector<Cell> row);

  [[nodiscard]] bool empty() const { return rows_.empty(); }

  /// Header and rows, each a line that starts with `indent`. Columns in which every cell is empty
  /// are left out.
  [[nodiscard]] std::string text(Color color, std::string_view indent = "") const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace mlcca::tools
