// SPDX-License-Identifier: BSD-2-Clause
// One publisher towards one place, over one route: the obstacles, and each of the five checks.
#pragma once
#include <cstddef>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/model/system.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"

namespace mlcca::core {

/// Subscribers of a channel at one place.
struct Target {
  Place place;
  std::vector<std::size_t> subscribers;
};

/// Those of a channel, in the order of its subscribers.
[[nodiscard]] std::vector<Target> targets_of(const Members& members, std::size_t channel);

/// The flow of a publisher on the hop of that number of its route: what it is promised there.
[[nodiscard]] Flow flow_on(const System& system, std::size_t publisher, const Route& route,
                           std::size_t hop);

/// What is asked of the networks between some ends.
struct Asked {
  AttributeSet set;  ///< normalised
  UserValues user;
};

/// What a publisher and all of these subscribers together ask, in the channel's attribute set of
/// that number.
[[nodiscard]] Asked asked_together(const Situation& situation, std::size_t publisher,
                                   const std::vector<std::size_t>& subscribers, std::size_t set);

/// The verdict of a publisher towards a target in an attribute set, with what both ask, before any
/// route has been checked.
[[nodiscard]] Verdict undecided(const Situation& situation, std::size_t channel,
                                std::size_t publisher, const Target& target, std::size_t set);

/// Fills in rows, obstacle, provision and outcome of a verdict that has its publisher, place,
/// subscribers, set, requirement and route. `targets` are all of the channel: some of them may
/// receive the events on the way. What is granted is reserved; otherwise the ledger is left as it
/// was.
void check_route(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
                 Verdict& verdict);

/// Once everything is decided: the rows and hops of a granted verdict with the response times of
/// the final schedules, which messages that were decided later have made longer.
void renew_responses(const Situation& situation, Ledger& ledger, const std::vector<Target>& targets,
                     Verdict& verdict);

}  // namespace mlcca::core
