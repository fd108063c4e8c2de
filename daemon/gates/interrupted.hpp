// SPDX-License-Identifier: BSD-2-Clause
// What a daemon that died between two generations has left.
#pragma once
#include "base/result.hpp"
#include "daemon/gates/control.hpp"

namespace mlcca::enforce {

/// Takes back on all gates what was written for the next generation: whoever steps to it for one
/// gate must not put half of an old change in force on the others. Before any gate is changed.
Result<void> undo_interrupted_step(const Control& control);

}  // namespace mlcca::enforce
