// SPDX-License-Identifier: BSD-2-Clause
// Computes the footprint of a channel: what it takes of shared networks beyond the standing
// promises. A gateway must reserve that before it uses it.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/admission/state.hpp"
#include "core/cluster/baseline.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster {

/// The footprint of the deliveries that the newcomer of a proposal takes part in, and of those that
/// are granted now and would be used otherwise, since the channel would get another attribute set.
/// Without a newcomer that of the whole channel. Left out is what a standing promise covers, and
/// what another gateway has reserved of the same traffic.
[[nodiscard]] Footprint footprint_of(const Proposal& proposal, const Baseline& baseline,
                                     std::size_t self);
/// The footprint of these deliveries of a proposal.
[[nodiscard]] Footprint footprint_of(const Proposal& proposal,
                                     std::span<const Verdict* const> deliveries,
                                     const Baseline& baseline, std::size_t self);
/// The footprint of the present decision of a channel.
[[nodiscard]] Footprint footprint_of(const State& state, std::size_t channel,
                                     const Baseline& baseline, std::size_t self);

/// The footprint of these granted deliveries of a state.
[[nodiscard]] Footprint footprint_of(const State& state, std::span<const Verdict* const> deliveries,
                                     const Baseline& baseline, std::size_t self);
/// Adds a gateway that has to agree to what is reserved, unless it is one already.
void add_gateway(Footprint& footprint, std::size_t gateway);

/// Deliveries that may not be used as they are proposed.
struct Want {
  std::vector<std::size_t> gateways;  ///< other gateways on the way of each, by rising index
  std::vector<const Verdict*> deliveries;
};
/// What a channel would be given more with a reservation. Each way over other gateways is a want of
/// its own, so that a gateway which does not carry one keeps nothing else closed. Where the channel
/// would get another attribute set, all its deliveries are one want.
[[nodiscard]] std::vector<Want> wants_of(const Proposal& wish, std::size_t self);

/// Adds what `gateway` has reserved of a network to what counts as held by others.
void add(Foreign& foreign, const Part& part, std::size_t gateway);

}  // namespace mlcca::core::cluster
