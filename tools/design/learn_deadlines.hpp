// SPDX-License-Identifier: BSD-2-Clause
// Deadlines, queue lengths and Periods for a description drafted from traffic, chosen so that its
// CAN buses can keep them. Traffic does not show what must arrive in time; without a Deadline a
// description requires the Period as Deadline, which a bus need not keep if senders have bursts.
#pragma once
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/design/inspect.hpp"
#include "core/model/system.hpp"
#include "tools/learn/draft.hpp"

namespace mlcca::tools::design {

/// Deadlines by name of channel, in ns, for channels whose response times on all buses and gateways
/// of their way together exceed the Period if everything that is described is sent. A Deadline is a
/// quarter longer than that sum. Channels without a bound are left out.
/// `buses`: what a check found out of them.
[[nodiscard]] std::map<std::string, std::uint64_t> deadlines_that_hold(
    const core::System& system, const core::InspectedBuses& buses);

/// The names of channels whose messages the transport protocol of J1939 cannot send as often as
/// their Period states, because of the pauses that it may make between packets.
[[nodiscard]] std::set<std::string> too_often_for_transport(const core::System& system,
                                                            const core::InspectedBuses& buses);

/// One note for each kind of finding that a check of `what` refuses, with the number of its
/// findings.
[[nodiscard]] std::vector<std::string> notes_on(const std::vector<core::Finding>& refused,
                                                std::string_view what);
/// Whether it is a note of notes_on().
[[nodiscard]] bool is_of_check(std::string_view note);

/// As draft_of(), with longer Periods where few events were seen, Deadlines that the buses can
/// keep, and queues that lose nothing.
[[nodiscard]] learn::Draft draft_that_holds(const learn::Observer& observer,
                                            const std::vector<std::string>& names,
                                            const learn::DraftOptions& options);

}  // namespace mlcca::tools::design
