// SPDX-License-Identifier: BSD-2-Clause
// Compares what is granted now with what another description would grant.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/admission/state.hpp"

namespace mlcca {

/// The deliveries that are granted in `now` and would be refused in `then`, the state of another
/// description that has its admissions and is not decided yet; one line each, with the reason. It
/// is decided here, with the networks as they are now.
///
/// `is_own`: whether an admission is one of this gateway. One of them that is not in `then` has no
/// place there, which is a loss. A described delivery that `then` does not describe is none, and
/// neither is what depends on what is not known yet, such as the links of another mesh.
[[nodiscard]] std::vector<std::string> lost_grants(
    const core::State& now, core::State& then,
    const std::function<bool(core::AdmissionId)>& is_own);

}  // namespace mlcca
