// SPDX-License-Identifier: BSD-2-Clause
// Senders that no description can have: whose node is nobody's, and those beyond what a gate
// distinguishes.
#pragma once
#include <string>
#include <vector>

#include "tools/learn/channels.hpp"

namespace mlcca::learn {

/// Takes them out of the channels, and channels without a sender out of all. A line for each, with
/// what to do about it. `names`: of the interfaces, by their numbers.
[[nodiscard]] std::vector<std::string> leave_out_senders(const Observer& observer,
                                                         const std::vector<std::string>& names,
                                                         std::vector<Channel>& channels);

}  // namespace mlcca::learn
