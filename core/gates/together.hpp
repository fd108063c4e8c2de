// SPDX-License-Identifier: BSD-2-Clause
// Merges the traffic and the supervision of two publishers whose frames cannot be distinguished.
#pragma once
#include "core/gates/plan.hpp"

namespace mlcca::core {

/// The policing of their joint traffic: the sum of the rates and of the bursts. A frame has at most
/// `longest` bytes.
[[nodiscard]] Policing together(Policing a, Policing b, Value longest);

/// The supervision of their joint events, of which either may arrive: silence is only reported if
/// nothing of both has been seen within the longer of the two times.
[[nodiscard]] Watching together(const Watching& a, const Watching& b);

}  // namespace mlcca::core
