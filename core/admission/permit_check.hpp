// SPDX-License-Identifier: BSD-2-Clause
// Compares what a granted delivery needs of shared networks with what this gateway may hold of
// them.
#pragma once
#include <cstddef>
#include <cstdint>
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

/// The first shared network of the verdict's route on which the gateway may not hold what its flow
/// has in the ledger; nullopt if there is none. Always nullopt without permits. `without`: as if
/// that reservation were not there.
[[nodiscard]] std::optional<Place> unpermitted(const Situation& situation, const Ledger& ledger,
                                               const Verdict& verdict,
                                               std::optional<std::uint64_t> without = std::nullopt);

/// The admissions of a delivery to one of which other gateways on its route have to agree. That of
/// the publisher is one for its own subscriber and for those of the description. Empty where the
/// description has both ends.
[[nodiscard]] std::vector<AdmissionId> admissions_to_agree(const Members& members,
                                                           const Verdict& verdict);

/// Why other gateways on the verdict's route do not carry it, where they have to agree: the first
/// one that has not, or a shared network while nothing that was agreed counts. nullopt if all have
/// agreed to one of its admissions. `without`: as if that reservation were not there.
[[nodiscard]] std::optional<std::pair<Obstacle, Place>> disagreement(
    const Situation& situation, const Verdict& verdict,
    std::optional<std::uint64_t> without = std::nullopt);

/// The first of the networks on which nothing can be reserved at present, with the reason.
[[nodiscard]] std::optional<std::pair<Obstacle, Place>> bar_on(const Wish& wish,
                                                               std::span<const Place> hops);

/// Identifies the source of a flow in terms that other gateways with the same description
/// understand.
[[nodiscard]] cluster::Source source_of(const Members& members, const Flow& flow);

/// The paths of a granted flow through the evaluated mesh at that hop; empty for any other network.
[[nodiscard]] std::vector<cluster::PathPart> paths_on(const System& system, const Members& members,
                                                      const Verdict& verdict, std::size_t hop);

/// The message of a flow on a bus together with the range of its identifiers, as it is reserved in
/// the store.
[[nodiscard]] cluster::BusPart bus_part_of(const System& system, const Members& members,
                                           const Flow& flow, const can::Message& message);

/// Whether another route avoids one of the gateways that forward the delivery, so that another
/// gateway could take over.
[[nodiscard]] bool has_another_way(const Topology& topology, const Members& members,
                                   const Verdict& verdict);

}  // namespace mlcca::core
