// SPDX-License-Identifier: BSD-2-Clause
// Reports of this gateway's place in its cluster, as the control protocol has them.
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
/// The reservations of one network, of one gateway, or all (nullopt); sorted by network, then by
/// gateway.
[[nodiscard]] control::ClusterReservations cluster_reservations(const Membership& membership,
                                                                const core::State& state,
                                                                std::optional<std::size_t> network,
                                                                std::optional<std::size_t> gateway);

}  // namespace mlcca
