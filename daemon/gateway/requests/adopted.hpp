// SPDX-License-Identifier: BSD-2-Clause
// Admissions of other gateways that go over this one: what Adopting does with them.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

/// Why it would not fit, with everything reserved that it needs; empty: it would.
[[nodiscard]] std::string misfit_of_adopted(Context& context, const control::Request& request);
/// Into state and gates. The error says why nothing was changed.
Result<void> admit_adopted(Context& context, const control::Request& request);
void remove_adopted(Context& context, const std::vector<core::AdmissionId>& gone);
/// Into a state that is not decided yet. What has no place there any more is left out.
void restore_adopted(core::State& state, const control::Request& request);

}  // namespace mlcca::requests
