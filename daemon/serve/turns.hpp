// SPDX-License-Identifier: BSD-2-Clause
// Decides whose turn it is. Users are in rings, each with those of its sessions that have work. The
// ring of users who may change something and the ring of all others alternate. Each user has a rate
// of steps. No I/O: times are arguments, in ns of any steady clock.
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

/// A burst, and a rate per second.
struct Rate {
  std::uint64_t burst = 0;
  std::uint64_t per_second = 0;
};

/// A token bucket of steps.
class Bucket {
 public:
  Bucket(Rate rate, std::uint64_t now) : rate_(rate), filled_(now), left_(rate.burst * kSecond) {}
  /// Takes one step. False if none is left.
  bool take(std::uint64_t now);
  /// When a step is available; at once if the result is not later than `now`.
  [[nodiscard]] std::uint64_t ready_at(std::uint64_t now);
  [[nodiscard]] bool full(std::uint64_t now);

 private:
  static constexpr std::uint64_t kSecond = 1'000'000'000;
  void fill(std::uint64_t now);
  Rate rate_;
  std::uint64_t filled_;
  std::uint64_t left_;  ///< in 1e-9 steps
};

/// The rings of users, and the lines of their sessions.
class Turns {
 public:
  /// A session, by a number of the caller's.
  using Id = int;
  struct User {
    uid_t uid = 0;
    bool member = false;  ///< root, or a member of the control group
    auto operator<=>(const User&) const = default;
  };

  Turns(Rate members, Rate others) : members_(members), others_(others) {}

  /// Adds a session that has work. It must not be in line already.
  void add(User user, Id session);
  void remove(User user, Id session);
  /// Takes the session whose turn it is out of the line; nullopt if no session is in line, or all
  /// of them have to wait for their rate.
  std::optional<Id> next(std::uint64_t now);
  /// Counts a further step of the user who has the turn; false if the user has to wait for the
  /// rate.
  bool step(User user, std::uint64_t now);
  /// When the first user that waits for its rate may continue; nullopt if none waits.
  [[nodiscard]] std::optional<std::uint64_t> next_ready(std::uint64_t now);
  [[nodiscard]] bool empty() const { return members_ring_.empty() && others_ring_.empty(); }
  /// Forgets users without sessions in line that have not used their rate lately.
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
  std::deque<User> members_ring_;  ///< each user once, with at least one session in line
  std::deque<User> others_ring_;
  bool members_turn_ = true;
};

/// A bucket for each user that has recently taken from it.
class Buckets {
 public:
  Buckets(Rate members, Rate others) : members_(members), others_(others) {}
  [[nodiscard]] const Rate& rate_of(Turns::User user) const {
    return user.member ? members_ : others_;
  }
  Bucket& of(Turns::User user, std::uint64_t now) {
    return users_.try_emplace(user, rate_of(user), now).first->second;
  }
  /// Forgets users whose buckets are full.
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
