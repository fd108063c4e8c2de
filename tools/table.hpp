// SPDX-License-Identifier: BSD-2-Clause
// Text tables for a terminal: columns as wide as their content, with colour on request.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools {

enum class Color : bool { no, yes };
enum class Style : std::uint8_t { plain, bold, dim, good, bad, warning };
enum class Align : std::uint8_t { left, right };

/// Whether output to `fd` is coloured: on a terminal, unless `forbidden`, NO_COLOR is set or TERM
/// is "dumb".
Color color_of(int fd, bool forbidden);

/// `text` with '?' for each control character, so that no name or alias can send commands to the
/// terminal.
std::string printable(std::string_view text);

/// The printable() text in the colour of `style`.
std::string styled(std::string_view text, Style style, Color color);

/// The text of a cell and its style.
struct Cell {
  std::string text;
  Style style = Style::plain;
};

/// The title and alignment of a column.
struct Column {
  std::string_view title;
  Align align = Align::left;
};

/// Collects rows and aligns them in columns.
class TextTable {
 public:
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// Adds a row with one cell for each column.
  void add(std::vector<Cell> row);

  [[nodiscard]] bool empty() const { return rows_.empty(); }

  /// Header and rows, each a line that begins with `indent`. Columns in which all cells are empty
  /// are left out.
  [[nodiscard]] std::string text(Color color, std::string_view indent = "") const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

}  // namespace mlcca::tools
