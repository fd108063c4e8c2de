// SPDX-License-Identifier: BSD-2-Clause
// Routes and reservations in the words of the control protocol.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/mesh/link_table.hpp"

namespace mlcca {

/// The ways that channels take or would take, and what their media give now; without links.
[[nodiscard]] control::Routes routes_report(const core::State& state);

/// Adds what is reported of a mesh's links, and what keeps its sources from knowing. `now`:
/// CLOCK_MONOTONIC ns.
void add_links(const core::mesh::Mesh& mesh, const core::mesh::LinkTable& table,
               const std::string& network, std::uint64_t now, control::Routes& out);

/// What is left of an admission's lease, ns; 0: it has none.
using LeaseOf = std::function<std::uint64_t(core::AdmissionId id)>;

/// Every resource, or those of one network or gateway, with who holds what.
[[nodiscard]] control::Reservations reservations_report(const core::State& state,
                                                        std::optional<core::Place> place,
                                                        const LeaseOf& lease_of);

}  // namespace mlcca
