// SPDX-License-Identifier: BSD-2-Clause
// Computes the footprint of a channel: what it takes of shared networks beyond the standing
// promises. A gateway must reserve that before it uses it.
#pragma once
#include <cstddef>

#include "core/admission/state.hpp"
#include "core/cluster/baseline.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster {

/// The footprint of the proposed decision of a channel, with all its endpoints. Left out is what a
/// standing promise covers, and what another gateway has reserved of the same traffic.
[[nodiscard]] Footprint footprint_of(const Proposal& proposal, const Baseline& baseline,
                                     std::size_t self);
/// The footprint of the present decision of a channel.
[[nodiscard]] Footprint footprint_of(const State& state, std::size_t channel,
                                     const Baseline& baseline, std::size_t self);

/// Adds what `gateway` has reserved of a network to what counts as held by others.
void add(Foreign& foreign, const Part& part, std::size_t gateway);

}  // namespace mlcca::core::cluster
