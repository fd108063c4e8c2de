// SPDX-License-Identifier: BSD-2-Clause
// Remarks for a person about what was seen, beside the draft.
#pragma once
#include <string>
#include <vector>

#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// The remarks, a line each. `names` are the interface names by their numbers. Without
/// `drafts_networks` a description has the networks, so nothing is assumed of them.
[[nodiscard]] std::vector<std::string> remarks_on(const Observer& observer,
                                                  const std::vector<std::string>& names,
                                                  bool drafts_networks);

}  // namespace mlcca::learn
