// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/arrivals.hpp"

#include <iterator>
#include <string>

namespace mlcca::serve {
namespace {

constexpr std::uint64_t kTidyInterval = 1'000'000'000;  // ns

}  // namespace

Result<void> Arrivals::let_in(Turns::User user, std::uint64_t now) {
  tidy(now);
  const Rate& rate = user.member ? members_ : others_;
  if (users_.try_emplace(user, rate, now).first->second.take(now)) return {};
  return fail("you connect too often: one user may do so " + std::to_string(rate.burst) +
              " times at once and " + std::to_string(rate.per_second) + " times a second");
}

/// Forgets who has not connected lately.
void Arrivals::tidy(std::uint64_t now) {
  if (now - tidied_ < kTidyInterval) return;
  tidied_ = now;
  for (auto user = users_.begin(); user != users_.end();)
    user = user->second.full(now) ? users_.erase(user) : std::next(user);
}

}  // namespace mlcca::serve
