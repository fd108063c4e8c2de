// SPDX-License-Identifier: BSD-2-Clause
// Limits how often the daemon forks: a fork copies the page tables of the complete process, and
// nothing else is done meanwhile. No I/O: times are arguments, in ns of any steady clock.
#pragma once
#include <sys/types.h>

#include <array>
#include <cstdint>

#include "daemon/serve/turns.hpp"

namespace mlcca {

/// A token bucket for each user, and a rest after each fork for the user's group (members of the
/// control group with root, or all others).
class ForkBudget {
 public:
  struct Rates {
    serve::Rate members;  ///< of one member
    serve::Rate others;
    /// After a fork that took t for a member, no member has another one for `rest` × t; the same
    /// for all other users. So neither group makes the other wait, and with 20 all forks take less
    /// than a tenth of the time of the loop.
    std::uint64_t rest = 0;
  };
  static constexpr Rates kUsual{{20, 10}, {4, 2}, 20};
  /// The longest rest, ns: the daemon may have been stopped in the middle of a fork, which makes
  /// the fork look long.
  static constexpr std::uint64_t kLongestRest = 10'000'000'000;

  explicit ForkBudget(Rates rates) : rest_(rates.rest), users_(rates.members, rates.others) {}
  /// When this user may fork; at once if the result is not later than `now`.
  [[nodiscard]] std::uint64_t ready_at(serve::Turns::User user, std::uint64_t now);
  /// Notes a fork for this user that took from `begin` to `end`.
  void forked(serve::Turns::User user, std::uint64_t begin, std::uint64_t end);
  /// Forgets users who have not forked lately.
  void tidy(std::uint64_t now) { users_.tidy(now); }
  [[nodiscard]] std::size_t users() const { return users_.size(); }

 private:
  std::uint64_t& rests_until(serve::Turns::User user) { return rests_until_.at(user.member); }
  std::uint64_t rest_;
  std::array<std::uint64_t, 2> rests_until_{};  ///< of all others, of members
  serve::Buckets users_;
};

}  // namespace mlcca
