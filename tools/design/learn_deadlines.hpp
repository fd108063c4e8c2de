// SPDX-License-Identifier: BSD-2-Clause
// Deadlines that the CAN buses of a drafted description can keep. Traffic does not say what must
// arrive in time, and without a Deadline a description asks for the Period: which a bus need not
// keep where senders have bursts.
#pragma once
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/model/system.hpp"
#include "tools/learn/draft.hpp"

namespace mlcca::tools::design {

/// By name of the channel, ns: of those that could take longer than they may, if everything that is
/// described is sent. A quarter is added to what they take. Channels without a bound are left out.
[[nodiscard]] std::map<std::string, std::uint64_t> deadlines_that_hold(const core::System& system);

/// Names of channels whose messages the transport protocol of J1939 cannot send as often as their
/// Period says, with the pauses that it may make between packets.
[[nodiscard]] std::set<std::string> too_often_for_transport(const core::System& system);

/// As draft_of(), with Periods of few events, Deadlines that can be kept, and queues that lose
/// nothing.
[[nodiscard]] learn::Draft draft_that_holds(const learn::Observer& observer,
                                            const std::vector<std::string>& names,
                                            learn::DraftOptions options);

}  // namespace mlcca::tools::design
