// SPDX-License-Identifier: BSD-2-Clause
// Whose turn it is: users in a ring, each with the sessions of his that have work; those who may
// change something and all others alternate. A user has so many steps a second. No I/O: time comes
// in as argument, in nanoseconds of any steady clock.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace mlcca::serve {

/// So many steps at once, and so many more each second.
struct Rate {
  std::uint64_t burst = 0;
  std::uint64_t per_second = 0;
};

/// A bucket that fills up with time.
class Bucket {
 public:
  Bucket(Rate rate, std::uint64_t now) : rate_(rate), filled_(now), left_(rate.burst * kSecond) {}
  /// False when there is nothing left.
  bool take(std::uint64_t now);
  /// When there is one again; not later than `now`: there is.
  [[nodiscard]] std::uint64_t ready_at(std::uint64_t now);
  [[nodiscard]] bool full(std::uint64_t now);

 private:
  static constexpr std::uint64_t kSecond = 1'000'000'000;
  void fill(std::uint64_t now);
  Rate rate_;
  std::uint64_t filled_;
  std::uint64_t left_;  ///< 1e-9 steps
};

class Turns {
 public:
  /// A session, by a number of the caller's.
  using Id = int;
  struct User {
    uid_t uid = 0;
    bool member = false;  ///< root, or in the control group
    auto operator<=>(const User&) const = default;
  };

  Turns(Rate members, Rate others) : members_(members), others_(others) {}

  /// A session that has work. It must not be in line already.
  void add(User user, Id session);
  void remove(User user, Id session);
  /// Takes the session whose turn it is off the line; nothing when no session is in line, or all
  /// that are must wait for their rate.
  std::optional<Id> next(std::uint64_t now);
  /// A further step of a user who has his turn; false when he has to wait for his rate.
  bool step(User user, std::uint64_t now);
  /// When the first user that waits for its rate may go on; nothing when none waits.
  [[nodiscard]] std::optional<std::uint64_t> next_ready(std::uint64_t now);
  [[nodiscard]] bool empty() const { return members_ring_.empty() && others_ring_.empty(); }
  /// Forgets users who have nothing in line and have not used their rate lately.
  void tidy(std::uint64_t now);
  [[nodiscard]] std::size_t users() const { return users_.size(); }

 private:
  struct Line {
    Bucket bucket;
    std::deque<Id> sessions;
  };
  Line& line_of(User user, std::uint64_t now);
  std::optional<Id> next_of(std::deque<User>& ring, std::uint64_t now);

  Rate members_;
  Rate others_;
  std::map<User, Line> users_;
  std::deque<User> members_ring_;  ///< each once, with at least one session in line
  std::deque<User> others_ring_;
  bool members_turn_ = true;
};

/// A bucket of each user who has taken from it lately.
class Buckets {
 public:
  Buckets(Rate members, Rate others) : members_(members), others_(others) {}
  [[nodiscard]] const Rate& rate_of(Turns::User user) const {
    return user.member ? members_ : others_;
  }
  Bucket& of(Turns::User user, std::uint64_t now) {
    return users_.try_emplace(user, rate_of(user), now).first->second;
  }
  /// Forgets those whose bucket is full.
  void tidy(std::uint64_t now) {
    for (auto user = users_.begin(); user != users_.end();)
      user = user->second.full(now) ? users_.erase(user) : std::next(user);
  }
  [[nodiscard]] std::size_t size() const { return users_.size(); }

 private:
  Rate members_;
  Rate others_;
  std::map<Turns::User, Bucket> users_;
};

}  // namespace mlcca::serve
