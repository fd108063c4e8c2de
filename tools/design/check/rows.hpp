// SPDX-License-Identifier: BSD-2-Clause
// An HTML table of the page. On a narrow screen CSS makes a card of each row, whose cells show the
// titles of their columns.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mlcca/satisfies.hpp"

namespace mlcca::tools::design {

/// Rows that a table shows at most; further ones are only counted.
inline constexpr std::size_t kMaxRows = 2000;

/// Builds a table. Cells are HTML; the first cell of a row is its heading. On a card, empty cells
/// are hidden.
class Rows {
 public:
  /// `title` must be HTML without tags.
  Rows(std::string title, std::vector<const char*> columns);

  /// Counts a row. False if it would not be shown, so that the caller need not make it.
  bool wants_more();
  void add(const std::vector<std::string>& cells, std::string_view kind = {},
           std::string_view id = {});

  /// Heading, `before` and the table as HTML; empty if there is no row.
  [[nodiscard]] std::string html(std::string_view before = {}) const;

 private:
  std::string title_;
  std::vector<const char*> columns_;
  std::string body_;
  std::size_t all_ = 0;
};

/// How an outcome appears: symbol, word and CSS class. The word alone suffices without colour.
struct Said {
  const char* mark;
  const char* word;
  const char* kind;
};
[[nodiscard]] Said said(Outcome outcome);
/// The HTML of these.
[[nodiscard]] std::string verdict(const Said& said);

/// "12.5 %" with a bar that is full at `limit_ppm`.
[[nodiscard]] std::string meter(std::uint64_t ppm, std::uint64_t limit_ppm);

/// HTML in which a path can be broken after its slashes.
[[nodiscard]] std::string path_text(std::string_view path);

}  // namespace mlcca::tools::design
