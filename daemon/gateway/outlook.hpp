// SPDX-License-Identifier: BSD-2-Clause
// Answers "what if": the state as it would be with other links, or without a network or a gateway.
#pragma once
#include <memory>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"

namespace mlcca {

/// A separate state, decided as the gateway would decide if that happened now. The error names what
/// is not known.
[[nodiscard]] Result<std::unique_ptr<core::State>> suppose(const core::State& now,
                                                           const control::WhatIfRequest& request);

/// The differences between the two states.
[[nodiscard]] control::WhatIf outlook(const core::State& now, const core::State& then);

}  // namespace mlcca
