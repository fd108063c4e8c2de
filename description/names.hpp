// SPDX-License-Identifier: BSD-2-Clause
// Names become indices; for one that nothing has, what was meant.
#pragma once
#include <cstddef>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/system.hpp"
#include "description/problems.hpp"

namespace mlcca::description {

/// Names of one kind, in their order. The first of a name counts; rules.hpp reports the others.
class Index {
 public:
  /// `kind` as a problem calls it.
  explicit Index(std::string_view kind) : kind_(kind) {}

  void reserve(std::size_t names);

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
};

/// "line 5", or "line 5 of motors.xml" where that is another file than `here`.
std::string line_words(const core::System& system, core::Origin here, core::Origin there);
std::string line_words(const std::vector<std::string>& files, core::Origin here,
                       core::Origin there);

}  // namespace mlcca::description
