// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/arrivals.hpp"

#include <string>

namespace mlcca::serve {
namespace {

constexpr std::uint64_t kTidyInterval = 1'000'000'000;  // ns

}  // namespace

Result<void> Arrivals::let_in(Turns::User user, std::uint64_t now) {
  tidy(now);
  if (users_.of(user, now).take(now)) return {};
  const Rate& rate = users_.rate_of(user);
  return fail("you connect too often: one user may do so " + std::to_string(rate.burst) +
              " times at once and " + std::to_string(rate.per_second) + " times a second");
}

/// Forgets users who have not connected lately.
void Arrivals::tidy(std::uint64_t now) {
  if (now - tidied_ < kTidyInterval) return;
  tidied_ = now;
  users_.tidy(now);
}

}  // namespace mlcca::serve
