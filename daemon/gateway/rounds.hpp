// SPDX-License-Identifier: BSD-2-Clause
// Divides the periodic work of the daemon into rounds: each turn of the loop does as much of a
// round as its budget of time allows, and the next turn continues (ADR 28).
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/clock.hpp"

namespace mlcca {

/// A list of jobs that are done once a round, piece by piece.
class Rounds {
 public:
  /// Does one short piece of a job; true if the round has more of this job. The data may change
  /// between two pieces.
  using Job = std::function<bool()>;
  using Clock = std::function<std::uint64_t()>;

  /// The budget of a turn, ns. The turn ends with the piece that exceeds it.
  static constexpr std::uint64_t kTurn = 1'000'000;

  explicit Rounds(Clock clock = monotonic_ns) : clock_(std::move(clock)) {}

  /// Adds a job. Jobs are done in the order of adding, once a round.
  void add(Job job) { jobs_.push_back(std::move(job)); }
  /// Begins a round. If one is under way, that one continues and the new one is omitted.
  void begin() {
    if (next_ == jobs_.size()) next_ = 0;
  }
  [[nodiscard]] bool under_way() const { return next_ < jobs_.size(); }
  /// Does one turn's part of the round.
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
  std::size_t next_ = 0;  ///< index in jobs_; jobs_.size(): no round is under way
};

}  // namespace mlcca
