// SPDX-License-Identifier: BSD-2-Clause
// Changes of the files of a description: elements that are inserted, and attributes of another
// value. All else stays byte by byte as it is, comments, too.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/model/system.hpp"
#include "tools/design/describe/markup.hpp"

namespace mlcca::tools::design {

class LearnPatch {
 public:
  /// Whose attribute it is.
  enum class Element : std::uint8_t { channel, publisher, gateway, network };
  struct Stated {
    core::Origin of;
    Element element = Element::channel;
    std::string_view key;  ///< of the short form; "period" and "jitter" in ns
    [[nodiscard]] auto rank() const { return std::tuple(of.file, of.line, element, key); }
    bool operator<(const Stated& other) const { return rank() < other.rank(); }
  };

  /// The files must not have changed since the system was read from them.
  explicit LearnPatch(const core::System& system) : system_(system) {}

  /// Elements at the end of the first file, and of a network.
  void insert_in_system(const std::string& text) { in_system_ += text; }
  void insert_in_network(const core::Origin& network, const std::string& text) {
    in_networks_.emplace_back(network, text);
  }
  /// A value in the place of the one that is there. Of values of one attribute the shortest time
  /// and the longest payload count. Nothing changes where elements state the attributes, as in the
  /// paper, and where there are several sets.
  void state(const Stated& attribute, std::uint64_t value);

  /// The path and new content of each file that changes. All changes are checked before the first
  /// is made: an error says which one is not possible.
  [[nodiscard]] Result<std::vector<std::pair<std::string, std::string>>> files();

 private:
  /// Text in the place of so many bytes at an offset of a file.
  struct Insertion {
    std::size_t at = 0;
    std::string text;
    std::size_t instead_of = 0;
  };
  struct Changes {
    std::map<std::string, std::vector<Insertion>> insertions;  ///< by path
    /// Of publishers without a list: what it must have, by file and line.
    std::map<std::pair<std::uint32_t, int>, std::string> lists;
  };
  Result<const Markup*> markup_of(std::uint32_t file);
  Result<void> insert(const core::Origin& of, std::string_view element, const std::string& text,
                      Changes& to);
  Result<void> change(const Stated& attribute, std::uint64_t value, Changes& to);
  Result<void> add_lists(Changes& to);
  /// All changes, or why one of them is not possible.
  Result<Changes> changes();

  const core::System& system_;
  std::string in_system_;
  std::vector<std::pair<core::Origin, std::string>> in_networks_;
  std::map<Stated, std::uint64_t> values_;
  std::map<std::string, Markup> markups_;  ///< by path
};

/// A unified diff (diff -u) from the file `path` to the new content `text`.
Result<std::string> diff_of(const std::string& path, const std::string& text);

}  // namespace mlcca::tools::design
