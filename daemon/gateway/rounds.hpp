// SPDX-License-Identifier: BSD-2-Clause
// What the daemon does by itself, in rounds: each turn of the loop does as much of a round as its
// budget has time for, and the next turn goes on (ADR 28).
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/clock.hpp"

namespace mlcca {

class Rounds {
 public:
  /// Does one piece of a job, as short as one of its things can be; true when the round has more of
  /// this job. What it works on may be another one from piece to piece.
  using Job = std::function<bool()>;
  using Clock = std::function<std::uint64_t()>;

  /// Time of a turn, ns. It ends with the piece in which that has passed.
  static constexpr std::uint64_t kTurn = 1'000'000;

  explicit Rounds(Clock clock = monotonic_ns) : clock_(std::move(clock)) {}

  /// Jobs are done in the order of adding, once a round.
  void add(Job job) { jobs_.push_back(std::move(job)); }
  /// A new round, unless one is under way: then that goes on, and this one falls out.
  void begin() {
    if (next_ == jobs_.size()) next_ = 0;
  }
  [[nodiscard]] bool under_way() const { return next_ < jobs_.size(); }
  /// One turn's part of the round.
  void turn() {
    const std::uint64_t end = clock_() + kTurn;
    while (under_way()) {
      if (!jobs_[next_]()) ++next_;
      if (clock_() >= end) return;
    }
  }

 private:
  Clock clock_;
  std::vector<Job> jobs_;
  std::size_t next_ = 0;  ///< of the jobs; past them: no round is under way
};

}  // namespace mlcca
