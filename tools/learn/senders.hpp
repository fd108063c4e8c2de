// SPDX-License-Identifier: BSD-2-Clause
// Leaves out senders that a description cannot have.
#pragma once
#include <string>
#include <vector>

#include "tools/learn/channels.hpp"

namespace mlcca::learn {

/// Removes from the channels senders whose node number nobody may have, and those that a gate
/// cannot distinguish from others; then channels without a sender. Returns one line for each, with
/// what the user can do. `names` are the names of the interfaces, by their numbers.
[[nodiscard]] std::vector<std::string> leave_out_senders(const Observer& observer,
                                                         const std::vector<std::string>& names,
                                                         std::vector<Channel>& channels);

}  // namespace mlcca::learn
