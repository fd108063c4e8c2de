// SPDX-License-Identifier: BSD-2-Clause
// The steps of an admission: at once, or when the store that gateways share has decided.
#pragma once
#include <optional>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/requests/context.hpp"

namespace mlcca::requests {

/// What bars a newcomer whatever the networks carry: quotas, and limits.
[[nodiscard]] std::optional<Response> bars(const Context& context, const Asker& asker,
                                           const control::Admit& request, const Asked& asked);
/// A proposal of that admission is put in force if it fits; what it says otherwise.
[[nodiscard]] Response decided(Context& context, const Asker& asker, const control::Admit& request,
                               const Asked& asked, core::Proposal proposal);
/// The admission fits, and takes something of networks that gateways share: the response comes when
/// the store has decided, within seconds.
[[nodiscard]] Response ask_store(Context& context, const Asker& asker,
                                 const control::Admit& request);

}  // namespace mlcca::requests
