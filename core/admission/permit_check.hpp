// SPDX-License-Identifier: BSD-2-Clause
// What a granted delivery needs of networks that gateways share, against what may be held of them.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/model/members.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

/// The first network of the verdict's route on which its flow may not hold what it has in the
/// ledger; nothing where there is none.
[[nodiscard]] std::optional<Place> unpermitted(const Situation& situation, const Ledger& ledger,
                                               const Verdict& verdict);

/// The first of these networks of which nothing can be reserved now, and why.
[[nodiscard]] std::optional<std::pair<Obstacle, Place>> bar_on(const Wish& wish,
                                                               std::span<const Place> hops);

/// A flow in numbers that other gateways understand.
[[nodiscard]] cluster::Source source_of(const Members& members, const Flow& flow);

/// The ways of a granted flow through the mesh that is the hop of that number; none where it is no
/// mesh that is evaluated.
[[nodiscard]] std::vector<cluster::PathPart> paths_on(const System& system, const Members& members,
                                                      const Verdict& verdict, std::size_t hop);

/// The messages that a flow has on a bus, with the identifiers of their frames.
[[nodiscard]] cluster::BusPart bus_part_of(const System& system, const Members& members,
                                           const Flow& flow, const can::Message& message);

/// It could go round one of the gateways that carry it.
[[nodiscard]] bool has_another_way(const Topology& topology, const Members& members,
                                   const Verdict& verdict);

}  // namespace mlcca::core
