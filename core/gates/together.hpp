// SPDX-License-Identifier: BSD-2-Clause
// What is admitted and expected of two publishers that cannot be distinguished.
#pragma once
#include "core/gates/plan.hpp"

namespace mlcca::core {

/// The traffic of both, whose frames hold `longest` bytes at most: the sum of their rates, and what
/// both may send at once.
[[nodiscard]] Policing together(Policing a, Policing b, Value longest);

/// Events of either come: that none of both sends is seen after the longer of their times.
[[nodiscard]] Watching together(const Watching& a, const Watching& b);

}  // namespace mlcca::core
