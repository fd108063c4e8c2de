// SPDX-License-Identifier: BSD-2-Clause
// Changes of the files of a description: elements that are inserted, attributes of another value,
// and comments of `learn` on channels whose values change. All else stays byte by byte as it is.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
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
    Element element = Element::channel;
    std::size_t index = 0;  ///< in the elements of that kind of the system
    std::string_view key;   ///< of the short form; "period" and "jitter" in ns
    auto operator<=>(const Stated&) const = default;
  };

  /// The files must not have changed since the system was read from them.
  explicit LearnPatch(const core::System& system) : system_(system) {}

  /// Elements at the end of the first file, and of the network with that index.
  void insert_in_system(const std::string& text) { in_system_ += text; }
  void insert_in_network(std::size_t network, const std::string& text) {
    in_networks_.emplace_back(network, text);
  }
  /// What was seen of the channel with that index. It replaces the comment in front of the channel
  /// that says what was seen before, if a value of the channel or of a publisher changes.
  void seen(std::size_t channel, const std::string& words) { seen_[channel] = words; }
  /// Whether the files can be changed at all: they are read, and the first one can have more
  /// elements.
  [[nodiscard]] Result<void> can_change();
  /// A value in the place of the one that is there. Of values of one attribute the shortest time
  /// and the longest payload count. Nothing changes where elements state the attributes, as in the
  /// paper, and where there are several sets.
  void state(const Stated& attribute, std::uint64_t value);

  /// The path and new content of each file that changes. All changes are checked before the first
  /// is made: an error says which one is not possible.
  [[nodiscard]] Result<std::vector<std::pair<std::string, std::string>>> files();
  /// After files(): the elements that it left as they are, because several begin on one line and
  /// it cannot be told which one is meant.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  /// The position of an element: the path of its file, and the offset there.
  using At = std::pair<std::string, std::size_t>;
  /// Text in the place of so many bytes at an offset of a file.
  struct Insertion {
    std::size_t at = 0;
    std::string text;
    std::size_t instead_of = 0;
  };
  struct Changes {
    std::map<std::string, std::vector<Insertion>> insertions;  ///< by path
    /// Of publishers without a list: what it must have.
    std::map<At, std::pair<const Node*, std::string>> lists;
  };
  /// A value of an attribute of an element that was found.
  struct Found {
    const Node* node = nullptr;
    Element element = Element::channel;
    std::uint64_t value = 0;
    std::optional<std::size_t> channel = {};  ///< index of the channel that it is about
  };
  Result<const Markup*> markup_of(std::uint32_t file);
  /// The root element, before whose end elements are inserted.
  Result<const Node*> system();
  /// nullptr, and a note, if it cannot be told which element it is.
  Result<const Node*> node_of(Element element, std::size_t index);
  Result<std::map<std::pair<At, std::string_view>, Found>> found_values();
  void insert(const std::string& path, const Node& node, const std::string& text, Changes& to);
  Result<void> insert_in_networks(Changes& to);
  Result<void> insert_at_end(Changes& to);
  [[nodiscard]] std::optional<std::size_t> channel_of(const Stated& attribute) const;
  /// False if nothing can be changed there.
  static bool change(const At& at, std::string_view key, const Found& found, Changes& to);
  void add_lists(Changes& to);
  Result<void> replace_comment(std::size_t channel, const std::string& words, Changes& to);
  /// All changes, or why one of them is not possible.
  Result<Changes> changes();

  const core::System& system_;
  std::string in_system_;
  std::vector<std::pair<std::size_t, std::string>> in_networks_;  ///< by index of the network
  std::map<Stated, std::uint64_t> values_;
  std::map<std::size_t, std::string> seen_;  ///< by channel
  std::map<std::string, Markup> markups_;    ///< by path
  std::vector<std::string> notes_;
};

/// A unified diff (diff -u) from the file `path` to the new content `text`.
Result<std::string> diff_of(const std::string& path, const std::string& text);

}  // namespace mlcca::tools::design
