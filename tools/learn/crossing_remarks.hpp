// SPDX-License-Identifier: BSD-2-Clause
// What a person should know of what goes on from one interface to another.
#pragma once
#include <string>
#include <vector>

#include "tools/learn/channels.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// A line each. `names`: of the interfaces, by their numbers; `drafted`: what the channels became,
/// in their order.
[[nodiscard]] std::vector<std::string> remarks_on_crossings(
    const Observer& observer, const std::vector<std::string>& names,
    const std::vector<Channel>& channels, const std::vector<DraftChannel>& drafted);

}  // namespace mlcca::learn
