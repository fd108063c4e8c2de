// SPDX-License-Identifier: BSD-2-Clause
// How often the daemon may fork: a fork copies the page tables of all that it has, and nothing else
// is done meanwhile. No I/O: time comes in as argument, in nanoseconds of any steady clock.
#pragma once
#include <sys/types.h>

#include <array>
#include <cstdint>

#include "daemon/serve/turns.hpp"

namespace mlcca {

class ForkBudget {
 public:
  struct Rates {
    serve::Rate members;  ///< of one user
    serve::Rate others;
    /// After a fork for a member no other member has one for so many times as long as it took, and
    /// the same for all other users: neither group makes the other wait, and with 20 all forks take
    /// less than a tenth of the time of the loop.
    std::uint64_t rest = 0;
  };
  static constexpr Rates kUsual{{20, 10}, {4, 2}, 20};
  /// The rest takes no longer than that, ns: the daemon may have been stopped in the middle of a
  /// fork.
  static constexpr std::uint64_t kLongestRest = 10'000'000'000;

  explicit ForkBudget(Rates rates) : rest_(rates.rest), users_(rates.members, rates.others) {}
  /// When this user may fork; not later than `now`: he may.
  [[nodiscard]] std::uint64_t ready_at(serve::Turns::User user, std::uint64_t now);
  /// He did, from `begin` to `end`.
  void forked(serve::Turns::User user, std::uint64_t begin, std::uint64_t end);
  /// Forgets users who have not forked lately.
  void tidy(std::uint64_t now) { users_.tidy(now); }
  [[nodiscard]] std::size_t users() const { return users_.size(); }

 private:
  std::uint64_t& rests_until(serve::Turns::User user) { return rests_until_.at(user.member); }
  std::uint64_t rest_;
  std::array<std::uint64_t, 2> rests_until_{};  ///< all others, members
  serve::Buckets users_;
};

}  // namespace mlcca
