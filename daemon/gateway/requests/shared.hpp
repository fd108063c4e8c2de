// SPDX-License-Identifier: BSD-2-Clause
// Functions that several handlers share.
#pragma once
#include <cstddef>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/replies.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca::requests {

/// What is known of deliveries, made in one turn or by a child process.
[[nodiscard]] Response known(const ChannelReports& channels, const ReportEstimates& estimates,
                             const Replies& replies, const Asker& asker,
                             const ParsedRequest& asked);
/// Withdraws or reinstates a channel: on disk first, then in the kernel. After an error nothing has
/// changed.
[[nodiscard]] Result<void> set_withdrawn(const WithdrawParts& parts, std::size_t channel,
                                         bool withdrawn);
/// What a new admission would be given; or an error that says that there is no endpoint on the
/// other side to do `to_do` with. `membership` is null if the gateway is in no cluster.
[[nodiscard]] Body outcome_of(const Scene& scene, const DeliveryHealth& delivery_health,
                              const Membership* membership, const core::Proposal& proposal,
                              const ParsedRequest& asked, const char* to_do);
/// A proposal that only answers a question and must not be accepted. Where gateways share networks
/// (`membership` is not null), it is decided as if what it needs were reserved. Everything must be
/// settled.
[[nodiscard]] core::Proposal as_it_could_be(core::State& state, const Membership* membership,
                                            const core::Admission& admission);
/// Why there cannot be the additional pairs of ends that this request makes; nullopt if there can.
/// Each pair is decided and reported: one channel may have as many as in a description, and all
/// channels as many as memory allows, also at the next start.
[[nodiscard]] std::optional<std::string> lacks_pairs(const core::State& state,
                                                     const ParsedRequest& asked);

}  // namespace mlcca::requests
