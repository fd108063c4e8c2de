// SPDX-License-Identifier: BSD-2-Clause
// What a channel takes of the networks that several gateways share, beyond what the description
// promises: what a gateway has to reserve before it may use it.
#pragma once
#include <cstddef>

#include "core/admission/state.hpp"
#include "core/cluster/baseline.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster {

/// Of a channel as it would be decided, with all of its ends; what a standing promise covers is
/// left out, and what another gateway has reserved of the same traffic that this one carries.
[[nodiscard]] Footprint footprint_of(const Proposal& proposal, const Baseline& baseline,
                                     std::size_t self);
/// Of a channel as it is decided.
[[nodiscard]] Footprint footprint_of(const State& state, std::size_t channel,
                                     const Baseline& baseline, std::size_t self);

/// What a gateway has reserved of a network counts for the others.
void add(Foreign& foreign, const Part& part, std::size_t gateway);

}  // namespace mlcca::core::cluster
