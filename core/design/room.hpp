// SPDX-License-Identifier: BSD-2-Clause
// Classifies rows about room that channels share.
#pragma once
#include <algorithm>
#include <string>

#include "core/model/system.hpp"
#include "core/model/text.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Whether the row is about a medium whose free room depends on all channels and not on one
/// delivery.
[[nodiscard]] inline bool is_about_medium(const Row& row) {
  return row.against == Against::schedule || row.against == Against::medium_time;
}
/// Whether the row is unfit because of what other channels hold.
[[nodiscard]] inline bool is_for_want_of_room(const Row& row) {
  return is_unfit(row) && (row.against == Against::capacity || is_about_medium(row));
}

/// The first such row of a verdict; null if there is none.
[[nodiscard]] inline const Row* want_of_room(const Verdict& v) {
  const auto found = std::ranges::find_if(v.rows, is_for_want_of_room);
  return found == v.rows.end() ? nullptr : &*found;
}
/// Text for a channel that competes with best cases.
[[nodiscard]] inline std::string open_room_words(const System& system, const Row& row) {
  return "whether " + name_of(system, row.place) +
         " has room for it beside what else is decided at run time";
}

}  // namespace mlcca::core
