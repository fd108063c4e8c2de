// SPDX-License-Identifier: BSD-2-Clause
// Remarks for a person about events that cross from one interface to another.
#pragma once
#include <string>
#include <vector>

#include "tools/learn/channels.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// The remarks, a line each. `names` are the interface names by their numbers; `drafted` are the
/// drafted channels in the order of `channels`.
[[nodiscard]] std::vector<std::string> remarks_on_crossings(
    const Observer& observer, const std::vector<std::string>& names,
    const std::vector<Channel>& channels, const std::vector<DraftChannel>& drafted);

}  // namespace mlcca::learn
