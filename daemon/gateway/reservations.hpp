// SPDX-License-Identifier: BSD-2-Clause
// Turns routes and reservations into messages of the control protocol.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/mesh/link_table.hpp"

namespace mlcca {

/// The routes that channels take or would take, and what their media give now; without links.
[[nodiscard]] control::Routes routes_report(const core::State& state);

/// Adds the reported links of a mesh, and what keeps its sources from knowing them. `now`:
/// CLOCK_MONOTONIC ns.
void add_links(const core::mesh::Mesh& mesh, const core::mesh::LinkTable& table,
               const std::string& network, std::uint64_t now, control::Routes& out);

/// The remaining time of an admission's lease, ns; 0 if it has none.
using LeaseOf = std::function<std::uint64_t(core::AdmissionId id)>;

/// The resources of everything, or of one network or gateway (`place`), with their holders.
[[nodiscard]] control::Reservations reservations_report(const core::State& state,
                                                        std::optional<core::Place> place,
                                                        const LeaseOf& lease_of);

}  // namespace mlcca
