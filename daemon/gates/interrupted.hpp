// SPDX-License-Identifier: BSD-2-Clause
// Repairs what a daemon has left that died between two generations.
#pragma once
#include "base/result.hpp"
#include "daemon/gates/control.hpp"

namespace mlcca::gates {

/// Reverts on all gates what was written for the next generation: otherwise the next step for one
/// gate would put half of an old change in force on the others. To be called before any gate is
/// changed.
Result<void> undo_interrupted_step(const Control& control);

}  // namespace mlcca::gates
