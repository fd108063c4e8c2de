// SPDX-License-Identifier: BSD-2-Clause
// What a description may say and hardly means: notes, which refuse nothing.
#pragma once
#include <vector>

#include "core/design/findings.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {

/// Periods of this length and more on a channel with a safe side are reported.
inline constexpr Value kLongPeriod = 3'600'000'000'000;  // ns, one hour

/// MLCCA038 to 041, of the preferred attribute sets: one note at most of each kind for a channel or
/// a port.
void add_sense_notes(const System& system, const Members& members, std::vector<Finding>& to);

}  // namespace mlcca::core
