// SPDX-License-Identifier: BSD-2-Clause
// What a person should know of what was seen, beside the draft.
#pragma once
#include <string>
#include <vector>

#include "tools/learn/observer.hpp"

namespace mlcca::learn {

/// A line each. `names`: of the interfaces, by their numbers.
[[nodiscard]] std::vector<std::string> remarks_on(const Observer& observer,
                                                  const std::vector<std::string>& names);

}  // namespace mlcca::learn
