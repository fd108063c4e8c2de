// SPDX-License-Identifier: BSD-2-Clause
// Records what an import or export assumed, and what has no counterpart on the other side.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::tools::design {

/// Things of one kind. All are counted; the first ones are kept with their lines.
struct Lack {
  std::string kind;  ///< short and stable, for programs: "no-cycle"
  std::string what;  ///< what was done with them, as a sentence without a full stop
  struct Item {
    int line = 0;  ///< 0: the file in general
    std::string text;
  };
  std::vector<Item> items;
  std::size_t count = 0;
};

/// At most so many items of a kind are kept, which JSON lists.
inline constexpr std::size_t kMostItems = 65'536;
/// At most so many items of a kind are in the text for a person.
inline constexpr std::size_t kMostInText = 20;

/// The lists of all kinds.
class Lacks {
 public:
  /// Adds an item to its kind; `line` 0 means the file in general.
  void add(std::string_view kind, std::string_view what, int line, std::string item);
  /// Adds the items of another file.
  void add(const Lack& of_another, std::string_view file);
  [[nodiscard]] const std::vector<Lack>& all() const { return all_; }

 private:
  std::vector<Lack> all_;  ///< in the order of their first items
};

/// The lists as text for a person; `file` precedes the line numbers.
std::string to_text(const Lacks& lacks, std::string_view file);

}  // namespace mlcca::tools::design
