// SPDX-License-Identifier: BSD-2-Clause
// What rows say of room that channels share.
#pragma once
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// What a medium has left depends on everybody, not on one pair of ends.
[[nodiscard]] inline bool is_about_medium(const Row& row) {
  return row.against == Against::schedule || row.against == Against::medium_time;
}
/// What others hold is in the way.
[[nodiscard]] inline bool is_for_want_of_room(const Row& row) {
  return is_unfit(row) && (row.against == Against::capacity || is_about_medium(row));
}

}  // namespace mlcca::core
