// SPDX-License-Identifier: BSD-2-Clause
// Subscribers of publishers that another gateway of the cluster has admitted. That gateway makes
// the admission, for this one.
#pragma once
#include <cstddef>
#include <optional>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {
class Membership;
class Recorder;
}  // namespace mlcca

namespace mlcca::requests {

/// The gateway that admits the subscriber of the request, because it has admitted the publisher
/// that the request means: by the store, or because no other gateway has a port where that
/// publisher is. nullopt: this gateway decides itself.
/// `membership` is null if the gateway is in no cluster.
[[nodiscard]] std::optional<std::size_t> gateway_to_ask(const Scene& scene,
                                                        const Recorder& recorder,
                                                        const Membership* membership,
                                                        const control::ChannelRequest& request,
                                                        const ParsedRequest& asked);
/// Why this gateway alone cannot say what would be granted; nullopt if it can. The text has the
/// command to use at the other gateway.
[[nodiscard]] std::optional<std::string> decided_elsewhere(const Scene& scene,
                                                           const Recorder& recorder,
                                                           const Membership* membership,
                                                           const control::ChannelRequest& request,
                                                           const ParsedRequest& asked);
/// The subscriber of such a request, as this gateway takes it in: its publisher comes with the
/// admission of the other gateway.
[[nodiscard]] control::Admit subscriber_alone(control::Admit request, core::AdmissionId id);
/// What other gateways need to know of a request: without the key and the lease, and with a name of
/// the subscriber.
[[nodiscard]] control::Admit what_others_need(const control::Request& request);
/// What to ask of the other gateway.
[[nodiscard]] Reserving::Wish wish_elsewhere(const std::string& channel,
                                             const control::Request& request, std::size_t gateway);

}  // namespace mlcca::requests
