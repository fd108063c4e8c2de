// SPDX-License-Identifier: BSD-2-Clause
// A check for requests about the part that this gateway takes in its cluster.
#pragma once
#include <fmt/core.h>

#include <optional>
#include <string>

#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/requests/response.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca::requests {

/// Why this gateway cannot carry out the request: it takes part in no cluster, or another gateway
/// is meant. nullopt if it can.
inline std::optional<control::Error> bars_part(const Scene& scene, const Membership* membership,
                                               const std::string& gateway, const char* verb) {
  const auto& system = scene.state->system();
  const std::string& self = system.gateways[scene.self].name;
  if (membership == nullptr)
    return invalid(
        fmt::format("{} takes part in no cluster: /etc/mlcca/cluster.conf is not there", self));
  if (gateway.empty() || gateway == self) return std::nullopt;
  return invalid(fmt::format(
      "this is {}, and each gateway alone writes what it takes part in: run 'mlccactl cluster {}' "
      "on {}",
      self, verb, gateway));
}

}  // namespace mlcca::requests
