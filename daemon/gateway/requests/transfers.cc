// SPDX-License-Identifier: BSD-2-Clause
// Transfers: what programs carry from one network of the gateway to another.
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response transfers(Context& context, const Asker& asker, const control::TransfersRequest& request) {
  if (request.user == asker.peer.uid && request.user != 0 && asker.peer.is_in_other_network)
    return error_of(control::ErrorKind::forbidden,
                    "a program that carries events must be in the network namespace of mlccad");
  // A program that asks for the transfers of its own user carries them, until its connection ends.
  if (request.user == asker.peer.uid) context.carriers.add(asker.peer.session, asker.peer.uid);
  if (request.channel.empty())
    return made_in_slices(context, 0,
                          [&context, user = request.user, at = std::size_t{0}]() mutable {
                            return context.endpoints.some_transfers(at, user);
                          });
  const auto channel = channel_named(*context.scene.state, request.channel);
  if (!channel) return invalid(channel.error().text);
  const auto make = [&context, channel = *channel, user = request.user] {
    control::Transfers out;
    context.endpoints.add_transfers(channel, user, out);
    return out;
  };
  return context.channels.has_many_ends(*channel) ? made_aside(context, asker, make)
                                                  : Response(make());
}

}  // namespace mlcca::requests
