// SPDX-License-Identifier: BSD-2-Clause
// Reservations: what is promised of each network and gateway, and to whom.

#include "daemon/gateway/reservations.hpp"

#include <fmt/core.h>

#include <optional>

#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {

Response reservations(const ReservationsParts& parts, const Asker& asker,
                      const control::ReservationsRequest& request) {
  std::optional<core::Place> place;
  if (!request.place.empty()) {
    place = parts.scene.state->find_place(request.place);
    if (!place) return invalid(fmt::format("there is no network or gateway '{}'", request.place));
  }
  const auto make = [parts, place] {
    return reservations_report(*parts.scene.state, place,
                               [parts](core::AdmissionId id) -> std::uint64_t {
                                 return parts.admissions.remaining(id).value_or(0);
                               });
  };
  return parts.replies.made(asker, parts.estimates.is_large(), make);
}

}  // namespace mlcca::requests
