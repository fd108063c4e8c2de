// SPDX-License-Identifier: BSD-2-Clause
// Finds statements of a description that are allowed but hardly intended. They become notes, which
// refuse nothing.
#pragma once
#include <vector>

#include "core/design/findings.hpp"
#include "core/model/members.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {

/// Periods of at least this length (ns) on a channel with a safe side are reported.
inline constexpr Value kLongPeriod = 3'600'000'000'000;  // ns, one hour

/// Adds the notes MLCCA038 to 041 for the preferred attribute sets, at most one of each kind per
/// channel or port.
void add_sense_notes(const System& system, const Members& members, std::vector<Finding>& to);

}  // namespace mlcca::core
