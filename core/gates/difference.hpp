// SPDX-License-Identifier: BSD-2-Clause
// Computes the changes from one sorted list of rules to another, of entries or of slots.
#pragma once
#include "core/model/progress.hpp"

namespace mlcca::core {

/// Both lists are sorted by `precedes` and have no duplicates. `name` returns what identifies a
/// rule that is removed or whose verdict changes. `same_traffic` compares policing and supervision.
/// Rules that are equal in both lists are not mentioned.
template <class Changes>
Changes difference_of(const auto& now, const auto& next, const auto& precedes, const auto& name,
                      const auto& same_traffic) {
  Changes changes;
  auto a = now.begin();
  auto b = next.begin();
  while (a != now.end() || b != next.end()) {
    Progress::step();
    if (b == next.end() || (a != now.end() && precedes(*a, *b))) {
      changes.remove.push_back(name(*a++));
      continue;
    }
    if (a == now.end() || precedes(*b, *a)) {
      changes.add.push_back(*b++);
      continue;
    }
    if ((*a).pass && !(*b).pass) changes.close.push_back(name(*a));
    if (!(*a).pass && (*b).pass) changes.open.push_back(name(*a));
    if (!same_traffic(*a, *b)) changes.police.push_back(*b);
    ++a;
    ++b;
  }
  return changes;
}

}  // namespace mlcca::core
