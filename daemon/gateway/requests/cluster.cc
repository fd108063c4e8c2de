// SPDX-License-Identifier: BSD-2-Clause
// Cluster: the standing of this gateway, the other members, or the reservations of each.
#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "daemon/gateway/cluster_report.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/requests/handlers.hpp"

namespace mlcca::requests {
namespace {

constexpr std::size_t kManyReservations = 512;

/// The reply of a gateway that is in no cluster.
Response in_no_cluster(const ClusterParts& parts, const std::string& part) {
  const std::string& self = parts.scene.state->system().gateways[parts.scene.self].name;
  if (part == "members")
    return control::ClusterMembers{.gateway = self, .system = {}, .members = {}};
  if (part == "reservations")
    return control::ClusterReservations{.gateway = self, .system = {}, .reservations = {}};
  control::Cluster out;
  out.gateway = self;
  out.health.state = control::HealthState::healthy;
  return out;
}

template <class Rows>
std::optional<std::size_t> named(const Rows& rows, const std::string& name) {
  const auto at = std::ranges::find_if(rows, [&](const auto& row) { return row.name == name; });
  if (at == rows.end()) return std::nullopt;
  return static_cast<std::size_t>(at - rows.begin());
}

Response reservations_of(const ClusterParts& parts, const Asker& asker,
                         const control::ClusterRequest& request) {
  const core::System& system = parts.scene.state->system();
  const auto network = named(system.networks, request.network);
  if (!network && !request.network.empty())
    return invalid(fmt::format("there is no network '{}'", request.network));
  const auto gateway = named(system.gateways, request.gateway);
  if (!gateway && !request.gateway.empty())
    return invalid(fmt::format("there is no gateway '{}'", request.gateway));
  const auto make = [parts, network, gateway] {
    return cluster_reservations(*parts.membership, *parts.scene.state, network, gateway);
  };
  const auto& known = parts.membership->member().view().records().reservations;
  return parts.replies.made(asker, known.size() > kManyReservations, make);
}

}  // namespace

Response cluster(const ClusterParts& parts, const Asker& asker,
                 const control::ClusterRequest& request) {
  const bool of_reservations = request.part == "reservations";
  if (!of_reservations && request.part != "members" && !request.part.empty())
    return invalid(fmt::format("a cluster has no '{}': members or reservations", request.part));
  if (!of_reservations && !(request.network.empty() && request.gateway.empty()))
    return invalid("only reservations are of a network or of a gateway");
  if (parts.membership == nullptr) return in_no_cluster(parts, request.part);
  if (of_reservations) return reservations_of(parts, asker, request);
  const core::State& state = *parts.scene.state;
  if (request.part.empty()) return cluster_report(*parts.membership, state);
  const auto make = [parts] { return cluster_members(*parts.membership, *parts.scene.state); };
  const auto& known = parts.membership->member().view().records().reservations;
  return parts.replies.made(asker, parts.estimates.is_large() || known.size() > kManyReservations,
                            make);
}

}  // namespace mlcca::requests
