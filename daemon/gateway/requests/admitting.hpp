// SPDX-License-Identifier: BSD-2-Clause
// The steps of an admission that is decided at once, or after the store of the cluster has decided.
#pragma once
#include <optional>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

/// Why the admission is refused whatever the networks carry: quotas and limits. nullopt if nothing
/// bars it.
[[nodiscard]] std::optional<Response> bars(const Context& context, const Asker& asker,
                                           const control::Admit& request, const Asked& asked);
/// Puts the proposal of an admission in force if it fits; returns the response in either case.
[[nodiscard]] Response decided(Context& context, const Asker& asker, const control::Admit& request,
                               const Asked& asked, core::Proposal proposal);
/// Reserves in the store what an admission takes of shared networks. The response comes within
/// seconds, when the store has decided.
[[nodiscard]] Response ask_store(Context& context, const Asker& asker,
                                 const control::Admit& request);

}  // namespace mlcca::requests
