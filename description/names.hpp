// SPDX-License-Identifier: BSD-2-Clause
// Resolves names to indices, and suggests a name for an unknown one.
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

/// The names of one kind in the order of the description. If a name occurs twice, the first one
/// counts; rules.hpp reports the others.
class Index {
 public:
  /// `kind`: the noun in problems, e.g. "channel".
  explicit Index(std::string_view kind) : kind_(kind) {}

  void reserve(std::size_t names);

  [[nodiscard]] bool empty() const { return names_.empty(); }

  /// `name` must outlive the index.
  void add(std::string_view name);

  /// The index of the name; nullopt, without a problem, if it is unknown.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const;

  /// The index of the name. An unknown one is reported, and nullopt is returned.
  std::optional<std::size_t> find(std::string_view name, core::Origin origin,
                                  std::string_view element, Problems& problems) const;

 private:
  std::string_view kind_;
  std::unordered_map<std::string_view, std::size_t> index_;
  std::vector<std::string_view> names_;
  /// The index behind the last one found: tried first, because descriptions mostly use names in the
  /// same order.
  mutable std::size_t next_ = 0;
};

/// Calls `say(first, again)` with the indices of things that have the same name. It sorts hashes,
/// which is cheaper than a table of all names; texts are compared only if hashes are equal.
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

/// "line 5", or "line 5 of motors.xml" if that is a file other than that of `here`.
std::string line_words(const core::System& system, core::Origin here, core::Origin there);
std::string line_words(const std::vector<std::string>& files, core::Origin here,
                       core::Origin there);

}  // namespace mlcca::description
