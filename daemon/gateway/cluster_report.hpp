// SPDX-License-Identifier: BSD-2-Clause
// How this gateway stands in its cluster, in the words of the control protocol.
#pragma once
#include <cstddef>
#include <optional>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/membership.hpp"

namespace mlcca {

[[nodiscard]] control::Cluster cluster_report(const Membership& membership,
                                              const core::State& state);
[[nodiscard]] control::ClusterMembers cluster_members(const Membership& membership,
                                                      const core::State& state);
/// Those of one network, of one gateway, or all; by network, then by gateway.
[[nodiscard]] control::ClusterReservations cluster_reservations(const Membership& membership,
                                                                const core::State& state,
                                                                std::optional<std::size_t> network,
                                                                std::optional<std::size_t> gateway);

}  // namespace mlcca
