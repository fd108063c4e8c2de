// SPDX-License-Identifier: BSD-2-Clause
// What would help a message that comes too late on a bus.
#pragma once
#include <string>

#include "core/admission/admission.hpp"
#include "core/can/schedule.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// A better identifier only where others are in its way, and the bus has time for all of them.
[[nodiscard]] std::string late_hint(const Situation& situation, const can::Schedule& bus,
                                    const Verdict& verdict, const Row& row);

}  // namespace mlcca::core
