// SPDX-License-Identifier: BSD-2-Clause
// The operations of Adopting on admissions of other gateways that cross this one.
#pragma once
#include <string>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/requests/context.hpp"
#include "daemon/gateway/reserving.hpp"

namespace mlcca::requests {

/// Why the admission would not fit with everything reserved that it needs, also one that is there
/// already; empty if it would.
[[nodiscard]] std::string misfit_of_adopted(Context& context, const control::Request& request);
/// What to reserve for a subscriber that another gateway has asked this one to admit. The error
/// says why it does not fit.
[[nodiscard]] Result<Reserving::Wish> wish_for_another(Context& context,
                                                       const control::Request& request,
                                                       std::size_t gateway);
/// Whether nobody publishes any more what that subscriber was admitted for.
[[nodiscard]] bool is_without_publisher(const Context& context, const control::Request& request);
/// Whether that is for good: no admission of this gateway brings such a publisher, not even one for
/// which the description has no place now.
[[nodiscard]] bool is_publisher_gone(const Context& context, const control::Request& request);
/// Adds the admission to state and gates, if it is not there. The error says why nothing was
/// changed.
Result<void> admit_adopted(Context& context, const control::Request& request);
/// Adds the admission to the state, whether it fits or not: its publisher is needed. Settling has
/// to follow. The error says why nothing was changed.
Result<void> take_in_adopted(Context& context, const control::Request& request);
void remove_adopted(Context& context, const std::vector<core::AdmissionId>& gone);
/// Adds the admission to a state that is not decided yet. What has no place there is left out.
void restore_adopted(core::State& state, const control::Request& request);

}  // namespace mlcca::requests
