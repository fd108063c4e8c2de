// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/fork_budget.hpp"

#include <algorithm>
#include <iterator>

namespace mlcca {

serve::Bucket& ForkBudget::bucket_of(serve::Turns::User user, std::uint64_t now) {
  return users_.try_emplace(user, user.member ? rates_.members : rates_.others, now).first->second;
}

std::uint64_t ForkBudget::ready_at(serve::Turns::User user, std::uint64_t now) {
  return std::max(bucket_of(user, now).ready_at(now), rests_until(user));
}

void ForkBudget::forked(serve::Turns::User user, std::uint64_t begin, std::uint64_t end) {
  bucket_of(user, begin).take(end);
  const std::uint64_t took = std::min(end - begin, kLongestRest);
  rests_until(user) = end + std::min(took * rates_.rest, kLongestRest);
}

void ForkBudget::tidy(std::uint64_t now) {
  for (auto user = users_.begin(); user != users_.end();)
    user = user->second.full(now) ? users_.erase(user) : std::next(user);
}

}  // namespace mlcca
