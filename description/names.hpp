// SPDX-License-Identifier: BSD-2-Clause
// Names become indices; for one that nothing has, what was meant.
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/model/system.hpp"
#include "description/problems.hpp"

namespace mlcca::description {

/// Names of one kind, in their order. The first of a name counts; rules.hpp reports the others.
class Index {
 public:
  /// `kind` as a problem calls it.
  explicit Index(std::string_view kind) : kind_(kind) {}

  void reserve(std::size_t names);

  [[nodiscard]] bool empty() const { return names_.empty(); }

  /// `name` must outlive the index.
  void add(std::string_view name);

  /// Nothing, without a word, where nothing has that name.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const;

  /// The same, with a problem.
  std::optional<std::size_t> find(std::string_view name, core::Origin origin,
                                  std::string_view element, Problems& problems) const;

 private:
  std::string_view kind_;
  std::unordered_map<std::string_view, std::size_t> index_;
  std::vector<std::string_view> names_;
  /// Behind the last one found: descriptions name things in the same order again and again.
  mutable std::size_t next_ = 0;
};

/// Calls `say(first, again)` with the numbers of things that have the same name. Cheaper than a
/// table of all names: only the rare equal hash makes it compare texts.
template <class Things, class Say>
void for_each_twice(const Things& things, const Say& say) {
  std::vector<std::pair<std::size_t, std::size_t>> hashes;
  hashes.reserve(things.size());
  for (std::size_t i = 0; i < things.size(); ++i)
    hashes.emplace_back(std::hash<std::string_view>{}(things[i].name), i);
  std::ranges::sort(hashes);
  for (std::size_t i = 0; i < hashes.size();) {
    std::size_t end = i + 1;
    while (end < hashes.size() && hashes[end].first == hashes[i].first) ++end;
    for (std::size_t b = i + 1; b < end; ++b)
      for (std::size_t a = i; a < b; ++a) {
        if (things[hashes[a].second].name != things[hashes[b].second].name) continue;
        say(hashes[a].second, hashes[b].second);
        break;
      }
    i = end;
  }
}

/// "line 5", or "line 5 of motors.xml" where that is another file than `here`.
std::string line_words(const core::System& system, core::Origin here, core::Origin there);
std::string line_words(const std::vector<std::string>& files, core::Origin here,
                       core::Origin there);

}  // namespace mlcca::description
