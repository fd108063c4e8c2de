// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/fork_budget.hpp"

#include <algorithm>

namespace mlcca {

std::uint64_t ForkBudget::ready_at(serve::Turns::User user, std::uint64_t now) {
  return std::max(users_.of(user, now).ready_at(now), rests_until(user));
}

void ForkBudget::forked(serve::Turns::User user, std::uint64_t begin, std::uint64_t end) {
  users_.of(user, begin).take(end);
  const std::uint64_t took = std::min(end - begin, kLongestRest);
  rests_until(user) = end + std::min(took * rest_, kLongestRest);
}

}  // namespace mlcca
