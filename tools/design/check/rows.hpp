// SPDX-License-Identifier: BSD-2-Clause
// A table of the page. On a narrow screen each row becomes a card, in which cells say their column.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mlcca/satisfies.hpp"

namespace mlcca::tools::design {

/// Rows of one table; more are counted, not shown.
inline constexpr std::size_t kMaxRows = 2000;

/// Cells are HTML; the first of a row is its heading. Empty cells do not show on a card.
class Rows {
 public:
  /// `title` is HTML without tags.
  Rows(std::string title, std::vector<const char*> columns);

  /// False where the row would not be shown: it need not be made.
  bool wants_more();
  void add(const std::vector<std::string>& cells, std::string_view kind = {},
           std::string_view id = {});

  /// Heading and table, or nothing where there is no row. `before`: HTML between the two.
  [[nodiscard]] std::string html(std::string_view before = {}) const;

 private:
  std::string title_;
  std::vector<const char*> columns_;
  std::string body_;
  std::size_t all_ = 0;
};

/// Mark, word and class of an outcome; the word carries it without colour.
struct Said {
  const char* mark;
  const char* word;
  const char* kind;
};
[[nodiscard]] Said said(Outcome outcome);
/// The same for any word.
[[nodiscard]] std::string verdict(const Said& said);

/// "12.5 %" with a bar for the eye; the bar is full at `limit_ppm`.
[[nodiscard]] std::string meter(std::uint64_t ppm, std::uint64_t limit_ppm);

/// Text in which a path may be broken behind its slashes.
[[nodiscard]] std::string path_text(std::string_view path);

}  // namespace mlcca::tools::design
