// SPDX-License-Identifier: BSD-2-Clause
// Hints for a message that is late on a bus.
#pragma once
#include <string>

#include "core/admission/admission.hpp"
#include "core/can/schedule.hpp"
#include "core/model/verdict.hpp"

namespace mlcca::core {

/// Suggests what would help. A better identifier is suggested only if other messages delay this one
/// and the bus has time for all of them.
[[nodiscard]] std::string late_hint(const Situation& situation, const can::Schedule& bus,
                                    const Verdict& verdict, const Row& row);

}  // namespace mlcca::core
