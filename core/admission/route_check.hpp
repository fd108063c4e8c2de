// SPDX-License-Identifier: BSD-2-Clause
// Checks one publisher towards one place over one route: all obstacles, and each kind of
// comparison.
#pragma once
#include <cstddef>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// The subscribers of a channel at one place.
struct Target {
  Place place;
  std::vector<std::size_t> subscribers;
};

/// The targets of a channel, in the order of its subscribers.
[[nodiscard]] std::vector<Target> targets_of(const Members& members, std::size_t channel);

/// The flow of a publisher on hop number `hop` of its route. It is the key of what is reserved
/// there.
[[nodiscard]] Flow flow_on(const System& system, std::size_t publisher, const Route& route,
                           std::size_t hop);

/// The joint requirements of some endpoints towards the networks between them.
struct JointRequirements {
  AttributeSet set;  ///< normalised: a Period implies a Deadline
  UserValues user;
};

/// The union of the requirements of a publisher and all of these subscribers, in the channel's
/// attribute set of that number.
[[nodiscard]] JointRequirements asked_together(const Situation& situation, std::size_t publisher,
                                               const std::vector<std::size_t>& subscribers,
                                               std::size_t set);

/// The verdict of a publisher towards a target before any route has been checked, with the union of
/// their requirements.
[[nodiscard]] Verdict undecided(const Situation& situation, std::size_t channel,
                                std::size_t publisher, const Target& target, std::size_t set);

/// Fills in rows, obstacle, provision and outcome of a verdict whose publisher, place, subscribers,
/// set, requirement and route are set. `targets` are those of the channel: some may overhear the
/// events on the route. A granted flow is reserved; otherwise the ledger is unchanged.
void check_route(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
                 Verdict& verdict);

/// Updates rows and hops of a granted verdict to the response times of the final schedules, see
/// renew_responses() in admission.hpp.
void renew_responses(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
                     Verdict& verdict);

}  // namespace mlcca::core
