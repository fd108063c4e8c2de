// SPDX-License-Identifier: BSD-2-Clause
// Reservations: what is promised of each network and gateway, and to whom.

#include "daemon/gateway/reservations.hpp"

#include <fmt/core.h>

#include <optional>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response reservations(Context& context, const Asker& asker,
                      const control::ReservationsRequest& request) {
  std::optional<core::Place> place;
  if (!request.place.empty()) {
    place = context.scene.state->find_place(request.place);
    if (!place) return invalid(fmt::format("there is no network or gateway '{}'", request.place));
  }
  const auto make = [&context, place] {
    return reservations_report(*context.scene.state, place,
                               [&context](core::AdmissionId id) -> std::uint64_t {
                                 return context.admissions.remaining(id).value_or(0);
                               });
  };
  if (context.channels.is_large()) return made_aside(context, asker, make);
  return make();
}

}  // namespace mlcca::requests
