// SPDX-License-Identifier: BSD-2-Clause
// Transfers: what programs carry from one network of the gateway to another.
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca::requests {

Response transfers(const TransfersParts& parts, const Asker& asker,
                   const control::TransfersRequest& request) {
  if (request.user == asker.peer.uid && request.user != 0 && asker.peer.is_in_other_network)
    return error_of(control::ErrorKind::forbidden,
                    "a program that carries events must be in the network namespace of mlccad");
  // A program that asks for the transfers of its own user carries them, until its connection ends.
  if (request.user == asker.peer.uid) parts.carriers.add(asker.peer.session, asker.peer.uid);
  if (request.channel.empty())
    return parts.replies.in_slices(0, [parts, user = request.user, at = std::size_t{0}]() mutable {
      return parts.endpoints.some_transfers(at, user);
    });
  const auto channel = channel_named(*parts.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const auto make = [parts, channel = *channel, user = request.user] {
    control::Transfers out;
    parts.endpoints.add_transfers(channel, user, out);
    return out;
  };
  return parts.replies.made(asker, parts.estimates.has_many_ends(*channel), make);
}

}  // namespace mlcca::requests
