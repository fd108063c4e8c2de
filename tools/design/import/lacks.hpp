// SPDX-License-Identifier: BSD-2-Clause
// What an import assumed, and what of a file has no counterpart in a description.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools::design {

/// Things of one kind: all are counted, the first ones are kept with their lines.
struct Lack {
  std::string kind;  ///< short and stable, for tools: "no-cycle"
  std::string what;  ///< what became of them, a sentence without a full stop
  struct Item {
    int line = 0;  ///< 0: the file as a whole
    std::string text;
  };
  std::vector<Item> items;
  std::size_t count = 0;
};

/// So many of a kind are listed.
inline constexpr std::size_t kMostItems = 20;

class Lacks {
 public:
  void add(std::string_view kind, std::string_view what, int line, std::string item);
  /// Those of another file.
  void add(const Lack& of_another, std::string_view file);
  [[nodiscard]] const std::vector<Lack>& all() const { return all_; }

 private:
  std::vector<Lack> all_;  ///< in the order in which their kinds came
};

/// The lines for a person; `file` stands in front of the line numbers.
std::string to_text(const Lacks& lacks, std::string_view file);

}  // namespace mlcca::tools::design
