// SPDX-License-Identifier: BSD-2-Clause
// What the gates hold, slot by slot: control traffic and channels, limits and counters.
#pragma once
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/ports/ports.hpp"

namespace mlcca {

/// Of all gated ports, or of the one whose interface or network has that name.
[[nodiscard]] control::Gates gates_report(const Ports& ports, const core::State& state,
                                          const std::string& place);

/// Interfaces and networks that have gates, in words.
[[nodiscard]] std::string gated_places(const Ports& ports);

}  // namespace mlcca
