// SPDX-License-Identifier: BSD-2-Clause
// Delay: a program that carries events reports that it took longer than the gateway states.
#include <fmt/core.h>

#include <algorithm>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/requests/handlers.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"

namespace mlcca::requests {
namespace {

std::string time_text(std::uint64_t ns) {
  return core::format_value(Attribute::latency, ns / 1'000 * 1'000);
}

}  // namespace

Response delay(const DelayParts& parts, const Asker& asker, const control::DelayRequest& request) {
  if (!parts.carriers.is(asker.peer.session, asker.peer.uid))
    return error_of(control::ErrorKind::forbidden,
                    "delays are reported by programs that carry events: ask for the transfers of "
                    "your own user first");
  const auto channel = channel_named(*parts.scene.state, core::format_subject(request.subject));
  if (!channel) return invalid(channel.error().text);
  control::Transfers carried;
  parts.endpoints.add_transfers(*channel, asker.peer.uid, carried);
  const auto transfer = std::ranges::find_if(carried.transfers, [&](const control::Transfer& t) {
    return t.publisher == request.publisher && t.from.network == request.from &&
           t.to.network == request.to;
  });
  if (transfer == carried.transfers.end() || transfer->latency_ns == 0 || request.late == 0)
    return control::Done{"nothing that is granted is late"};
  const std::string line = fmt::format(
      "{} ({}) of {}: {} from {} to {} by the program of user {} took up to {}, where the gateway "
      "states a Latency of {}",
      transfer->channel, core::format_subject(transfer->subject), transfer->publisher,
      many(request.late, "event"), request.from, request.to, asker.peer.uid,
      time_text(request.longest_ns), time_text(transfer->latency_ns));
  if (!parts.carriers.note_late({transfer->subject, transfer->publisher, request.to},
                                {parts.clock.monotonic_ns(), request.late, request.longest_ns}))
    return control::Done{"too soon after the last report"};
  parts.delivery_health.note_late(*channel);
  parts.log.warning(Kind::late, line,
                    {.subject = transfer->subject,
                     .channel = transfer->channel,
                     .network = request.to,
                     .publisher = transfer->publisher,
                     .late = request.late,
                     .longest_ns = request.longest_ns});
  return control::Done{line};
}

}  // namespace mlcca::requests
