// SPDX-License-Identifier: BSD-2-Clause
// The steps of an admission that is decided at once, or after the store of the cluster has decided.
#pragma once
#include <optional>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca::requests {

/// Why the admission is refused whatever the networks carry: quotas and limits. nullopt if nothing
/// bars it.
[[nodiscard]] std::optional<Response> bars(const AdmitParts& parts, const Asker& asker,
                                           const control::Admit& request,
                                           const ParsedRequest& asked);
/// Puts the proposal of an admission in force if it fits; returns the response in either case.
/// `through`: the gateway that has made it for this one; empty: none.
[[nodiscard]] Response decided(const AdmitParts& parts, const Asker& asker,
                               const control::Admit& request, const ParsedRequest& asked,
                               core::Proposal proposal, const std::string& through = {});
/// Whether other gateways are on the way of what the proposal admits, and must agree to it.
[[nodiscard]] bool crosses_others(const Scene& scene, const core::Proposal& proposal);
/// Reserves in the store what an admission takes of shared networks, with the agreement of all
/// gateways on its way. The response comes within seconds, when the store has decided.
[[nodiscard]] Response ask_store(const AdmitParts& parts, const Asker& asker,
                                 const control::Admit& request);
/// The same of an admission that another gateway makes for this one; see gateway_to_ask().
[[nodiscard]] Response ask_other_gateway(const AdmitParts& parts, const Asker& asker,
                                         const control::Admit& request);

}  // namespace mlcca::requests
